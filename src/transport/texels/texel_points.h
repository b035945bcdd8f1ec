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

/// The point on the other side of the surface.
inline SurfacePoint flipped(SurfacePoint point)
{
    point.normal = -point.normal;
    point.geometricNormal = -point.geometricNormal;
    return point;
}

/// Moves every second point that lies on a triangle with mean texels to the other side. Half of the texel's rays then
/// start on each side.
inline void spreadOverSides(const BakeGeometry& geometry, TexelPoints& points, int pointCount)
{
    if (geometry.texelSides.empty()) return;
    for (std::size_t p = 1; p < std::size_t(pointCount); p += 2)
        if (geometry.hasMeanTexels(points[p].triangle)) points[p] = flipped(points[p]);
}

/// Whether a point and a light are on different sides of a double-sided sheet whose sides share texels.
/// Shadow rays of such a texel start on the side that faces the light.
inline bool isBehindSheet(const BakeGeometry& geometry, const SurfacePoint& point, vec3 towardsLight)
{
    return glm::dot(point.geometricNormal, towardsLight) < 0.0f && geometry.sharesTexels(point.triangle);
}

/// Seed of a texel's random numbers: its place on the map, independent of which texels are baked.
inline uint32_t texelId(const TexelMap& map, const Texel& texel)
{
    return (texel.page * uint32_t(map.pageSize) + texel.y) * uint32_t(map.pageSize) + texel.x;
}

} // namespace halflight
