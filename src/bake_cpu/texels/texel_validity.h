#pragma once
// Validity of sample points: which of a texel's points are outside geometry.

#include "bake_cpu/sample/path_tracer.h"
#include "bake_cpu/texels/texel_points.h"

#include <optional>

namespace halflight {

/// Rays whose first hit is the hidden back of a surface (Materials::backIsHidden()). Counts saturate at 65535.
struct BackFaceHits {
    uint16_t hidden = 0;
    uint16_t solids = 0;       ///< of these, backs of solids
    float nearest = kInfinity; ///< distance of the nearest hidden back

    void add(BackFaceHits other)
    {
        hidden = uint16_t(std::min(hidden + other.hidden, 0xffff));
        solids = uint16_t(std::min(solids + other.solids, 0xffff));
        nearest = std::min(nearest, other.nearest);
    }
};

/// Tests points by rays. The rays depend on the texel alone, not on the bake's seed: validity is a property of the
/// scene.
class TexelValidity {
public:
    explicit TexelValidity(const PathTracer& paths);

    /// Points outside closed solids; kAllPoints if all are.
    PointMask outsideSolids(const TexelPoints& points, int pointCount, uint32_t texelId, uint64_t& rays) const;
    /// Points of `outsideSolids` that are not behind single-sided shells; kAllPoints if all are, 0 if fewer than an
    /// eighth are. `allHidden` = all rays of the texel so far hit hidden backs.
    PointMask outsideShells(const TexelPoints& points, int pointCount, PointMask outsideSolids, bool allHidden,
                            uint32_t texelId, uint64_t& rays) const;
    /// Points outside both.
    PointMask validPoints(const TexelPoints& points, int pointCount, uint32_t texelId, uint64_t& rays) const;

    /// First hits of rays that a texel has traced already.
    struct FirstHits {
        int rays = 0;
        BackFaceHits backs;
        PointMask untested = 0;       ///< points that none of the rays left
        bool mutuallyVisible = false; ///< no surface was found between the points
    };
    /// The same for a texel with a hidden back among its first hits. These restrict the tests: solids are tested only
    /// if one was hit, and mutually visible points far from all geometry are tested together.
    PointMask validPoints(const TexelPoints& points, int pointCount, FirstHits hits, uint32_t texelId,
                          uint64_t& rays) const;
    /// Whether the first of a texel's points is inside a solid.
    bool firstInSolid(const TexelPoints& points, uint32_t texelId, uint64_t& rays) const
    {
        return anySolid_ && insideSolids(points, 1, texelId, rays);
    }

private:
    bool insideSolids(const TexelPoints& points, PointMask group, uint32_t id, uint64_t& rays) const;
    PointMask behindShells(const TexelPoints& points, PointMask candidates, bool allHidden, uint32_t id,
                           uint64_t& rays) const;
    struct BackHits {
        PointMask points = 0;
        float nearest = kInfinity;
    };
    BackHits hitBacks(const TexelPoints& points, PointMask which, bool ofSolids, uint32_t id, int round,
                      uint64_t& rays) const;
    std::optional<bool> validTogether(const TexelPoints& points, int pointCount, const FirstHits& hits, uint32_t id,
                                      uint64_t& rays) const;
    PointMask visibleFromFirst(const TexelPoints& points, PointMask candidates, uint64_t& rays) const;
    RayTracer::Crossings crossingsFrom(const SurfacePoint& point, uint32_t id, int sample, uint64_t& rays) const;

    const PathTracer& paths_;
    bool anySolid_;
};

} // namespace halflight
