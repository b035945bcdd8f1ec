#pragma once
// Validity of sample points: which of a texel's points are outside geometry.

#include "transport/sample/path_tracer.h"
#include "transport/texels/near_triangles.h"
#include "transport/texels/texel_points.h"

#include <span>

namespace halflight {

/// A texel of a block, and which of its sample points are outside geometry.
struct BlockTexel {
    uint32_t texel = 0;  ///< index into TexelMap::texels
    uint32_t id = 0;     ///< texelId()
    bool wanted = false; ///< false: only a test of the whole block sets `valid`
    int pointCount = 0;
    TexelPoints points;
    OrientedBox box; ///< around the points
    PointMask valid = kAllPoints;
    bool open = false; ///< all its points have to be tested, and validPoints() has not been called
};

/// Tests points by rays. The rays depend on the texel alone, not on the bake's seed: validity is a property of the
/// scene.
class TexelValidity {
public:
    /// `leavesOpen`: testBlock() leaves to others what takes most rays, and sets BlockTexel::open.
    explicit TexelValidity(const PathTracer& paths, bool leavesOpen = false);

    /// Points outside closed solids; kAllPoints if all are.
    PointMask outsideSolids(const TexelPoints& points, int pointCount, uint32_t texelId, uint64_t& rays) const;
    /// Points of `outsideSolids` that are not behind single-sided shells; kAllPoints if all are, 0 if fewer than an
    /// eighth are.
    PointMask outsideShells(const TexelPoints& points, int pointCount, PointMask outsideSolids, uint32_t texelId,
                            uint64_t& rays) const;
    /// Tests texels of a chart that are next to one another. Where nothing stands between the points of all texels,
    /// these are mutually visible, and rays of some of them tell of all. Elsewhere few rays of each texel, and whether
    /// a surface is between its points, tell whether all its points have to be tested.
    void testBlock(std::span<BlockTexel> texels, uint64_t& rays) const;
    /// Points outside both.
    PointMask validPoints(const TexelPoints& points, int pointCount, uint32_t texelId, uint64_t& rays) const;

private:
    [[nodiscard]] vec3 raised(const SurfacePoint& point, float lift) const;
    [[nodiscard]] float liftOf(const TexelPoints& points) const;
    bool testTogether(std::span<BlockTexel> texels, uint64_t& rays) const;
    void testOne(BlockTexel& texel, const NearTriangles& near, uint64_t& rays) const;
    bool insideSolids(const TexelPoints& points, PointMask group, uint32_t id, uint64_t& rays) const;
    PointMask behindShells(const TexelPoints& points, PointMask candidates, uint32_t id, uint64_t& rays) const;
    PointMask hitBacks(const TexelPoints& points, PointMask which, uint32_t id, int round, uint64_t& rays) const;
    PointMask visibleFromFirst(const TexelPoints& points, PointMask candidates, uint64_t& rays) const;
    /// Candidates visible from a point. `lift`: height of the lines of sight above the surface, in metres.
    PointMask visibleFrom(const TexelPoints& points, int first, PointMask candidates, float lift, uint64_t& rays) const;
    /// RayKernels::crossings() of one ray of a point.
    int solidsLeft(const SurfacePoint& point, uint32_t id, int sample, uint64_t& rays) const;

    const PathTracer& paths_;
    bool leavesOpen_;
    bool anySolid_ = false;
    bool anyHiddenBack_ = false;
};

} // namespace halflight
