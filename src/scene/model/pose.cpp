#include "scene/model/pose.h"

#include <cmath>

namespace halflight {

mat4 poseLookingAlong(vec3 position, vec3 direction, vec3 up)
{
    const vec3 z = -glm::normalize(direction);
    if (glm::length(glm::cross(up, z)) < 1.0e-4f * glm::length(up) || !(glm::length(up) > 0.0f)) {
        up = std::abs(z.y) < 0.9f ? vec3(0, 1, 0) : vec3(0, 0, -1);
    }
    const vec3 x = glm::normalize(glm::cross(up, z));
    return {vec4(x, 0.0f), vec4(glm::cross(z, x), 0.0f), vec4(z, 0.0f), vec4(position, 1.0f)};
}

mat4 rigidPose(const mat4& transform)
{
    const vec3 z(transform[2]);
    if (!(glm::length(z) > 1.0e-20f)) return poseLookingAlong(vec3(transform[3]), vec3(0, 0, -1));
    const vec3 y(transform[1]);
    const float length = glm::length(y);
    return poseLookingAlong(vec3(transform[3]), -z, length > 1.0e-20f ? y / length : vec3(0.0f));
}

} // namespace halflight
