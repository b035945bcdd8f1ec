#pragma once
// Sample points of texels.

#include "halflight/bake/integrator.h"

#include <algorithm>
#include <array>
#include <cstdint>

namespace halflight {

/// Height of lines between points of a texel, patch or element above it, in its widths: more than that of a convex
/// surface between them.
constexpr float kLineLift = 0.1f;

using TexelPoints = std::array<SurfacePoint, kMaxTexelPoints>;

/// Moves the points of the mask to the front, in their order.
inline void keepPoints(PointMask mask, TexelPoints& points, int& pointCount)
{
    int kept = 0;
    for (int p = 0; p < pointCount; ++p) {
        if (mask & (1u << p)) points[std::size_t(kept++)] = points[std::size_t(p)];
    }
    pointCount = kept;
}

/// Seed of a texel's random numbers: its place on the map, independent of which texels are baked.
inline uint32_t texelId(const TexelMap& map, const Texel& texel)
{
    return (texel.page * uint32_t(map.pageSize) + texel.y) * uint32_t(map.pageSize) + texel.x;
}

} // namespace halflight
