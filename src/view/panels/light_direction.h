#pragma once
// Where a directional light comes from, as its panel has it.

#include "halflight/base/math.h"
#include "halflight/base/mathematics.h"

#include <algorithm>

namespace halflight::view {

/// Degrees. Height: over the horizon, -90 to 90. Bearing: about +Y, 0 at -Z, 90 at +X.
struct LightSource {
    float height = 0.0f;
    float bearing = 0.0f;
};

/// `direction`: along which the light shines, unit.
inline LightSource sourceOf(vec3 direction)
{
    const vec3 from = -direction;
    return {glm::degrees(math::atan(from.y, glm::length(vec2(from.x, from.z)))),
            glm::degrees(math::atan(from.x, -from.z))};
}

/// The pose of a light from there, whose -Z is the direction.
inline mat4 poseFrom(LightSource source, vec3 position)
{
    constexpr float kHighest = 89.9f; // straight above, a light would lose its bearing
    const float height = glm::radians(std::clamp(source.height, -kHighest, kHighest));
    const float bearing = glm::radians(source.bearing);
    const vec3 from(math::cos(height) * math::sin(bearing), math::sin(height), -math::cos(height) * math::cos(bearing));
    const vec3 right = glm::normalize(glm::cross(vec3(0.0f, 1.0f, 0.0f), from));
    return mat4(vec4(right, 0.0f), vec4(glm::cross(from, right), 0.0f), vec4(from, 0.0f), vec4(position, 1.0f));
}

} // namespace halflight::view
