#pragma once
// Points around a crossing of surfaces, between which rays show whether one surface hides two sides of the other.

#include "halflight/unwrap/unwrap.h"

#include <array>

namespace halflight {

/// Distances from a crossing in texels at which each side is tested: up to what a texel on the other side can cover.
inline constexpr std::array<float, 3> kCrossingDistances{0.3f, 0.7f, 1.25f};
inline constexpr std::size_t kPointsAround = 2 * kCrossingDistances.size();
/// Height of lines of sight above the surface in texels: above what a curved surface rises within those distances.
inline constexpr float kSightRise = 0.2f;
/// Height in texels at which the other surface still has to be in the way: a low edge hides little.
inline constexpr float kHiddenHeight = 3.0f;
/// Distance in texels of both ends of a seam's line of sight from the seam: more than its height, so that surfaces
/// which lean over by up to 45 degrees are in the way.
inline constexpr float kSeamDistance = 0.25f;

/// The points around a crossing above the surface: first those of one side, then those of the other.
inline std::array<vec3, kPointsAround> pointsAround(const CrossingPoint& crossing)
{
    constexpr std::size_t kCount = kCrossingDistances.size();
    std::array<vec3, kPointsAround> points{};
    for (std::size_t i = 0; i < points.size(); ++i) {
        const float distance = i < kCount ? kCrossingDistances[i] : -kCrossingDistances[i - kCount];
        points[i] =
            crossing.position + crossing.texelMeters * (distance * crossing.across + kSightRise * crossing.rise);
    }
    return points;
}

} // namespace halflight
