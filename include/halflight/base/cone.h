#pragma once

#include "halflight/base/math.h"
#include "halflight/base/mathematics.h"

#include <algorithm>
#include <cmath>

namespace halflight {

/// Whether an infinite cone meets a ball; near the apex and within rounding it errs towards "meets" (Wronski 2017,
/// "Cull that cone! Improved cone/spotlight visibility tests for tiled and clustered lighting"). `axis`: unit vector
/// from the apex. `halfAngle`: radians; from π / 2 on the cone counts as all of space.
inline bool coneMeetsBall(vec3 apex, vec3 axis, float halfAngle, vec3 center, float radius)
{
    if (halfAngle >= 0.5f * kPi) return true;
    const vec3 v = center - apex;
    const float along = glm::dot(v, axis);
    const float across = std::sqrt(std::max(0.0f, glm::dot(v, v) - along * along));
    const float outside = math::cos(halfAngle) * across - along * math::sin(halfAngle);
    const float slack = 1.0e-4f * (1.0f + glm::length(v));
    return outside <= radius + slack && along >= -radius - slack;
}

} // namespace halflight
