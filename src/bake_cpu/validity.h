#pragma once
// Which of a texel's points lie outside of geometry.

#include "bake_cpu/path.h"

#include "halflight/bake/integrator.h"

#include <array>
#include <cstdint>
#include <vector>

namespace halflight {

using TexelPoints = std::array<SurfacePoint, kMaxTexelPoints>;

/// Bit i: point i of a texel lies outside geometry; 0: (nearly) none does.
using PointMask = uint16_t;
static_assert(kMaxTexelPoints <= 16);
constexpr PointMask kAllPoints = 0xffff;

/// Of a map's texels, by their number: which of their points lie outside geometry, and whether that has been looked at
/// point by point.
struct OutsidePoints {
    explicit OutsidePoints(std::size_t texels) : masks(texels, kAllPoints), known(texels, 0) {}
    std::vector<PointMask> masks;
    std::vector<uint8_t> known;
};

/// Its rays depend on the place alone, not on any seed: a point is inside or it is not.
class PointValidity {
public:
    explicit PointValidity(const PathTracer& paths);

    /// Points outside of closed solids; kAllPoints where all of them are.
    PointMask outsideSolids(const TexelPoints& points, int pointCount, uint32_t texelId, uint64_t& rays) const;
    /// Of those, the ones that do not lie behind single-sided shells; kAllPoints where all are left, 0 where hardly
    /// any. `allHidden`: the texel's rays so far met nothing but hidden backs.
    PointMask outsideShells(const TexelPoints& points, int pointCount, PointMask outsideSolids, bool allHidden,
                            uint32_t texelId, uint64_t& rays) const;
    /// Outside of both.
    PointMask outside(const TexelPoints& points, int pointCount, uint32_t texelId, uint64_t& rays) const;
    /// What some rays of a texel met first.
    struct Met {
        int rays = 0;
        int hidden = 0;       ///< of them, those that met hidden backs
        int solids = 0;       ///< and those that met the inside of a solid
        PointMask others = 0; ///< points that none of them left
    };
    /// The same where some met a hidden back: looks only for what that can mean.
    PointMask outside(const TexelPoints& points, int pointCount, Met met, uint32_t texelId, uint64_t& rays) const;
    /// Whether the first of a texel's points lies inside a solid.
    bool firstInSolid(const TexelPoints& points, uint32_t texelId, uint64_t& rays) const
    {
        return anySolid_ && insideSolids(points, 1, texelId, rays);
    }
    /// Leaves only the points of the mask.
    static void keep(PointMask mask, TexelPoints& points, int& pointCount);

private:
    bool insideSolids(const TexelPoints& points, PointMask together, uint32_t id, uint64_t& rays) const;
    PointMask behindSurfaces(const TexelPoints& points, PointMask candidates, bool allHidden, uint32_t id,
                             uint64_t& rays) const;
    PointMask meetBacks(const TexelPoints& points, PointMask which, bool ofSolids, uint32_t id, int round,
                        uint64_t& rays) const;
    PointMask seenFromFirst(const TexelPoints& points, PointMask candidates, uint64_t& rays) const;
    SurfaceTracer::Crossings crossingsFrom(const SurfacePoint& point, uint32_t id, int sample, uint64_t& rays) const;

    const PathTracer& paths_;
    bool anySolid_;
};

/// What seeds a texel's random numbers: its place, whatever else the bake covers.
inline uint32_t texelId(const TexelMap& map, const Texel& texel)
{
    return (texel.page * uint32_t(map.pageSize) + texel.y) * uint32_t(map.pageSize) + texel.x;
}

} // namespace halflight
