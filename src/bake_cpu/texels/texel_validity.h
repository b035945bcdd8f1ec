#pragma once
// Which of a texel's points lie outside of geometry.

#include "bake_cpu/sample/path_tracer.h"

#include "halflight/bake/integrator.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

namespace halflight {

using TexelPoints = std::array<SurfacePoint, kMaxTexelPoints>;

/// Bit i: point i of a texel lies outside geometry; 0: (nearly) none does.
using PointMask = uint16_t;
static_assert(kMaxTexelPoints <= 16);
constexpr PointMask kAllPoints = 0xffff;

/// Of a map's texels, by their number: which of their points lie outside geometry.
struct ValidPoints {
    explicit ValidPoints(std::size_t texels) : masks(texels, kAllPoints), known(texels, 0), together(texels, 0) {}
    std::vector<PointMask> masks;
    std::vector<uint8_t> known;    ///< whether that has been looked at
    std::vector<uint8_t> together; ///< whether nothing was found that stands between the points
};

/// Rays that met the inside of a surface; from 65535 on they are not counted.
struct BackFaceHits {
    uint16_t hidden = 0;       ///< that nobody is meant to see
    uint16_t solids = 0;       ///< of them, those of solids
    float nearest = kInfinity; ///< distance of the nearest hidden one

    void add(BackFaceHits other)
    {
        hidden = uint16_t(std::min(hidden + other.hidden, 0xffff));
        solids = uint16_t(std::min(solids + other.solids, 0xffff));
        nearest = std::min(nearest, other.nearest);
    }
};

/// Its rays depend on the place alone, not on any seed: a point is inside or it is not.
class TexelValidity {
public:
    explicit TexelValidity(const PathTracer& paths);

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
        BackFaceHits backs;
        PointMask others = 0;  ///< points that none of them left
        bool together = false; ///< whether nothing was found that stands between the points
    };
    /// The same where some met a hidden back: looks only for what that can mean. Points that nothing stands between,
    /// and nothing near, are outside all together or not at all.
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
    struct MetPoints {
        PointMask points = 0;
        float nearest = kInfinity;
    };
    MetPoints meetBacks(const TexelPoints& points, PointMask which, bool ofSolids, uint32_t id, int round,
                        uint64_t& rays) const;
    std::optional<bool> outsideTogether(const TexelPoints& points, int pointCount, const Met& met, uint32_t id,
                                        uint64_t& rays) const;
    PointMask seenFromFirst(const TexelPoints& points, PointMask candidates, uint64_t& rays) const;
    RayTracer::Crossings crossingsFrom(const SurfacePoint& point, uint32_t id, int sample, uint64_t& rays) const;

    const PathTracer& paths_;
    bool anySolid_;
};

/// What seeds a texel's random numbers: its place, whatever else the bake covers.
inline uint32_t texelId(const TexelMap& map, const Texel& texel)
{
    return (texel.page * uint32_t(map.pageSize) + texel.y) * uint32_t(map.pageSize) + texel.x;
}

} // namespace halflight
