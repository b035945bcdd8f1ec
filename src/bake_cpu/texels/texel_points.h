#pragma once
// Sample points of texels and which of them are valid.

#include "halflight/bake/integrator.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

namespace halflight {

using TexelPoints = std::array<SurfacePoint, kMaxTexelPoints>;

/// Bit i = point i of a texel is valid: outside geometry. 0 = the texel is invalid.
using PointMask = uint16_t;
static_assert(kMaxTexelPoints <= 16);
constexpr PointMask kAllPoints = 0xffff;

/// Valid sample points of a map's texels, by texel.
struct ValidPoints {
    explicit ValidPoints(std::size_t texels) : masks(texels, kAllPoints), checked(texels, 0), mutuallyVisible(texels, 0)
    {}
    std::vector<PointMask> masks;
    std::vector<uint8_t> checked;         ///< the mask is a result of TexelValidity
    std::vector<uint8_t> mutuallyVisible; ///< no surface was found between the texel's points
};

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
