#pragma once
// Eight texels, one per lane, with their sample points.

#include "transport/random/stratified_pattern.h"
#include "transport/sample/path_tracer.h"
#include "transport/texels/texel_points.h"
#include "transport/trace/lanes.h"

#include "halflight/base/parallel.h"
#include "halflight/shading/sampling.h"

#include <array>
#include <atomic>
#include <span>

namespace halflight {

/// Which of a texel's points a group has.
enum class PointUse { Valid, All };

class TexelGroup {
public:
    /// A texel whose points are all valid takes batch batchOf(id) of texelPoints(); other batches of partly valid
    /// texels have not been tested.
    template<typename BatchOf> TexelGroup(const PathTracer& paths, const TexelMap& map,
                                          std::span<const uint32_t> texels, PointUse use, const BatchOf& batchOf)
        : lanes_(int(texels.size()))
    {
        const BakeGeometry& geometry = paths.surfaces().geometry();
        for (int lane = 0; lane < lanes_; ++lane) {
            Lane& l = lane_[std::size_t(lane)];
            const Texel& texel = map.texels[texels[std::size_t(lane)]];
            l.texel = texels[std::size_t(lane)];
            l.id = texelId(map, texel);
            l.mask = use == PointUse::All ? kAllPoints : texel.validPoints;
            if (l.mask == 0) continue;
            l.pointCount = texelPoints(geometry, map, texel, l.points, l.mask == kAllPoints ? batchOf(l.id) : 0);
            keepPoints(l.mask, l.points, l.pointCount);
        }
    }
    TexelGroup(const PathTracer& paths, const TexelMap& map, std::span<const uint32_t> texels,
               PointUse use = PointUse::Valid)
        : TexelGroup(paths, map, texels, use, [](uint32_t) { return 0; })
    {}
    /// All points of texels, on the back of the surface.
    static TexelGroup backs(const PathTracer& paths, const TexelMap& map, std::span<const uint32_t> texels)
    {
        TexelGroup group(paths, map, texels, PointUse::All);
        for (int lane = 0; lane < group.lanes_; ++lane) {
            Lane& l = group.lane_[std::size_t(lane)];
            l.onBack = true;
            for (SurfacePoint& point : l.points) point = flipped(point);
        }
        return group;
    }
    /// Sides of triangles in place of texels, with 15 points each.
    struct Side {
        uint32_t triangle = 0;
        bool back = false;
    };
    /// Seed of its random numbers.
    static uint32_t idOf(const Side& side) { return hashPcg(2 * side.triangle + (side.back ? 1u : 0u)); }
    static TexelGroup triangles(const PathTracer& paths, std::span<const Side> sides)
    {
        TexelGroup group;
        group.lanes_ = int(sides.size());
        for (int lane = 0; lane < group.lanes_; ++lane) {
            Lane& l = group.lane_[std::size_t(lane)];
            const Side& side = sides[std::size_t(lane)];
            l.id = idOf(side);
            l.mask = kAllPoints;
            l.onBack = side.back;
            l.pointCount = kTrianglePoints;
            for (int i = 0; i < kTrianglePoints; ++i) {
                vec2 b = r2Point(i);
                if (b.x + b.y > 1.0f) b = 1.0f - b;
                const SurfacePoint point = surfacePoint(paths.surfaces().geometry(), side.triangle, b);
                l.points[std::size_t(i)] = side.back ? flipped(point) : point;
            }
        }
        return group;
    }

    [[nodiscard]] int lanes() const { return lanes_; }
    [[nodiscard]] bool active(int lane) const { return lane < lanes_ && lane_[std::size_t(lane)].pointCount > 0; }
    /// The first active lane; lanes() if there is none.
    [[nodiscard]] int firstActive() const
    {
        int lane = 0;
        while (lane < lanes_ && !active(lane)) ++lane;
        return lane;
    }
    [[nodiscard]] uint32_t texel(int lane) const { return lane_[std::size_t(lane)].texel; }
    /// Seed of the lane's random numbers: texelId(), or a hash of the triangle's side.
    [[nodiscard]] uint32_t id(int lane) const { return lane_[std::size_t(lane)].id; }
    [[nodiscard]] const TexelPoints& points(int lane) const { return lane_[std::size_t(lane)].points; }
    [[nodiscard]] int pointCount(int lane) const { return lane_[std::size_t(lane)].pointCount; }
    [[nodiscard]] bool onBack(int lane) const { return lane_[std::size_t(lane)].onBack; }
    /// The points that the group was made with.
    [[nodiscard]] PointMask mask(int lane) const { return lane_[std::size_t(lane)].mask; }

    /// Point `number`, modulo the number of points.
    [[nodiscard]] const SurfacePoint& point(int lane, int number) const
    {
        const Lane& l = lane_[std::size_t(lane)];
        return l.points[std::size_t(number % l.pointCount)];
    }
    /// Index of the origin of a stratum's ray.
    [[nodiscard]] int pointOf(int lane, int block, int stratum) const
    {
        const Lane& l = lane_[std::size_t(lane)];
        return shading::gatherPointOf(l.id, l.pointCount, block, stratum);
    }

protected:
    void spreadOverSides(const BakeGeometry& geometry)
    {
        for (int lane = 0; lane < lanes_; ++lane)
            halflight::spreadOverSides(geometry, lane_[std::size_t(lane)].points, lane_[std::size_t(lane)].pointCount);
    }

private:
    TexelGroup() = default;

    static_assert(kMaxTexelPoints == StratifiedPattern::kBlock);
    static constexpr int kTrianglePoints = kMaxTexelPoints - 1;
    struct Lane {
        uint32_t texel = 0;
        uint32_t id = 0;
        PointMask mask = 0;
        bool onBack = false;
        int pointCount = 0;
        TexelPoints points;
    };

    int lanes_ = 0;
    std::array<Lane, kLanes> lane_;
};

/// A texel group with ray origins and frames of its points.
class GatherGroup : public TexelGroup {
public:
    /// The gather of texels: those of sheets with mean texels have points on both sides.
    GatherGroup(const PathTracer& paths, const TexelMap& map, std::span<const uint32_t> texels)
        : TexelGroup(paths, map, texels)
    {
        spreadOverSides(paths.surfaces().geometry());
        setOrigins(paths);
    }
    GatherGroup(const PathTracer& paths, const TexelGroup& group) : TexelGroup(group) { setOrigins(paths); }

    struct Origin {
        vec3 position;
        vec3 tangent;
        vec3 bitangent;
        vec3 normal;
        vec3 geometricNormal;
    };
    [[nodiscard]] const Origin& origin(int lane, int point) const
    {
        return origins_[std::size_t(lane)][std::size_t(point)];
    }
    /// Whether all points of each texel have the same frame.
    [[nodiscard]] bool flat() const { return flat_; }

private:
    void setOrigins(const PathTracer& paths)
    {
        for (int lane = 0; lane < lanes(); ++lane) setOrigins(paths, lane);
    }
    void setOrigins(const PathTracer& paths, int lane)
    {
        for (int p = 0; p < pointCount(lane); ++p) {
            Origin& origin = origins_[std::size_t(lane)][std::size_t(p)];
            const SurfacePoint& point = points(lane)[std::size_t(p)];
            const Origin& first = origins_[std::size_t(lane)][0];
            if (p > 0 && point.normal == first.normal && point.geometricNormal == first.geometricNormal) {
                origin = first;
            } else {
                flat_ = flat_ && p == 0;
                origin.normal = point.normal;
                origin.geometricNormal = point.geometricNormal;
                shading::orthonormalBasis(point.normal, origin.tangent, origin.bitangent);
            }
            origin.position = paths.surfaces().rayOrigin(point);
        }
    }

    std::array<std::array<Origin, kMaxTexelPoints>, kLanes> origins_;
    bool flat_ = true;
};

/// Calls a body for texels 0…count-1 of a list, eight at a time, on all threads. texelAt(i) returns a texel,
/// makeGroup(texels) a group of up to eight. makeBody() returns a body with scratch memory for each run of texels:
/// body(group, first, rays), where `first` is the list's index of lane 0.
template<typename TexelAt, typename MakeGroup, typename MakeBody>
Status forTexelGroups(const RayTracer& tracer, std::size_t count, const TexelAt& texelAt, const MakeGroup& makeGroup,
                      const Progress& progress, const char* stage, std::atomic<uint64_t>& rayCount,
                      const MakeBody& makeBody)
{
    constexpr std::size_t kGrain = 64;
    const bool finished = parallelFor(count, kGrain, progress, stage, [&](std::size_t begin, std::size_t end) {
        auto body = makeBody();
        uint64_t rays = 0;
        std::array<uint32_t, kLanes> texels;
        for (std::size_t i = begin; i < end && !progress.cancelled() && !tracer.failed(); i += kLanes) {
            const std::size_t lanes = std::min(end - i, std::size_t(kLanes));
            for (std::size_t k = 0; k < lanes; ++k) texels[k] = texelAt(i + k);
            body(makeGroup(std::span<const uint32_t>(texels.data(), lanes)), i, rays);
        }
        rayCount += rays;
    });
    return tracer.outcome(finished);
}

} // namespace halflight
