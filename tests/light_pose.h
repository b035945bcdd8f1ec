#pragma once

#include "halflight/base/math.h"

namespace halflight::test {

/// A light's pose: at `position`, shining along `direction`.
inline mat4 lightPose(vec3 position, vec3 direction)
{
    const vec3 z = -glm::normalize(direction);
    const vec3 up = std::abs(z.y) < 0.99f ? vec3(0, 1, 0) : vec3(1, 0, 0);
    const vec3 x = glm::normalize(glm::cross(up, z));
    return {vec4(x, 0), vec4(glm::cross(z, x), 0), vec4(z, 0), vec4(position, 1)};
}

} // namespace halflight::test
