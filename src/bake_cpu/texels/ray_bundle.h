#pragma once
// Eight texels side by side, and the bundles of rays that leave them together.

#include "bake_cpu/sample/path_tracer.h"
#include "bake_cpu/sample/stratified_pattern.h"
#include "bake_cpu/texels/texel_validity.h"
#include "bake_cpu/trace/lanes.h"

#include "halflight/base/parallel.h"
#include "halflight/shading/sampling.h"

#include <array>
#include <atomic>
#include <span>

namespace halflight {

/// The other side of the surface.
inline SurfacePoint backOf(SurfacePoint point)
{
    point.normal = -point.normal;
    point.geometricNormal = -point.geometricNormal;
    return point;
}

class TexelGroup {
public:
    static constexpr int kLanes = embree::kPacket;

    /// `outside`: which of each texel's points to use. Those are told of batch 0; texels of which some points are left
    /// out have no others. batchOf(id) names the batch of the others.
    template<typename BatchOf>
    TexelGroup(const PathTracer& paths, const TexelMap& map, std::span<const uint32_t> texels,
               std::span<const PointMask> outside, const BatchOf& batchOf)
        : lanes_(int(texels.size()))
    {
        const BakeGeometry& geometry = paths.surfaces().geometry();
        for (int lane = 0; lane < lanes_; ++lane) {
            Lane& l = lane_[std::size_t(lane)];
            const Texel& texel = map.texels[texels[std::size_t(lane)]];
            l.texel = texels[std::size_t(lane)];
            l.id = texelId(map, texel);
            l.mask = outside[std::size_t(lane)];
            if (l.mask == 0) continue;
            l.pointCount = texelPoints(geometry, map, texel, l.points, l.mask == kAllPoints ? batchOf(l.id) : 0);
            TexelValidity::keep(l.mask, l.points, l.pointCount);
        }
    }
    TexelGroup(const PathTracer& paths, const TexelMap& map, std::span<const uint32_t> texels,
               std::span<const PointMask> outside)
        : TexelGroup(paths, map, texels, outside, [](uint32_t) { return 0; })
    {}
    /// The backs of texels: all points of each.
    static TexelGroup backs(const PathTracer& paths, const TexelMap& map, std::span<const uint32_t> texels)
    {
        std::array<PointMask, kLanes> all;
        all.fill(kAllPoints);
        TexelGroup group(paths, map, texels, all);
        for (int lane = 0; lane < group.lanes_; ++lane) {
            Lane& l = group.lane_[std::size_t(lane)];
            l.behind = true;
            for (SurfacePoint& point : l.points) point = backOf(point);
        }
        return group;
    }
    /// Triangles in place of texels; `behind`: seen from their backs. Points spread over each.
    struct Side {
        uint32_t triangle = 0;
        bool behind = false;
    };
    static TexelGroup triangles(const PathTracer& paths, std::span<const Side> sides)
    {
        TexelGroup group;
        group.lanes_ = int(sides.size());
        for (int lane = 0; lane < group.lanes_; ++lane) {
            Lane& l = group.lane_[std::size_t(lane)];
            const Side& side = sides[std::size_t(lane)];
            l.id = hashPcg(2 * side.triangle + (side.behind ? 1u : 0u));
            l.mask = kAllPoints;
            l.behind = side.behind;
            l.pointCount = kTrianglePoints;
            for (int i = 0; i < kTrianglePoints; ++i) {
                vec2 b = r2Point(i);
                if (b.x + b.y > 1.0f) b = 1.0f - b;
                const SurfacePoint point = surfacePoint(paths.surfaces().geometry(), side.triangle, b);
                l.points[std::size_t(i)] = side.behind ? backOf(point) : point;
            }
        }
        return group;
    }

    [[nodiscard]] int lanes() const { return lanes_; }
    [[nodiscard]] bool active(int lane) const { return lane < lanes_ && lane_[std::size_t(lane)].pointCount > 0; }
    /// The first lane with a texel that has points; lanes() if there is none.
    [[nodiscard]] int firstActive() const
    {
        int lane = 0;
        while (lane < lanes_ && !active(lane)) ++lane;
        return lane;
    }
    [[nodiscard]] uint32_t texel(int lane) const { return lane_[std::size_t(lane)].texel; }
    [[nodiscard]] uint32_t id(int lane) const { return lane_[std::size_t(lane)].id; }
    [[nodiscard]] const TexelPoints& points(int lane) const { return lane_[std::size_t(lane)].points; }
    [[nodiscard]] int pointCount(int lane) const { return lane_[std::size_t(lane)].pointCount; }
    /// Whether the points are on the back of the surface.
    [[nodiscard]] bool behind(int lane) const { return lane_[std::size_t(lane)].behind; }
    /// The texel's points that are in use: those the group was made with.
    [[nodiscard]] PointMask mask(int lane) const { return lane_[std::size_t(lane)].mask; }

    /// The texel's points in turn, again and again.
    [[nodiscard]] const SurfacePoint& point(int lane, int number) const
    {
        const Lane& l = lane_[std::size_t(lane)];
        return l.points[std::size_t(number % l.pointCount)];
    }
    /// Number of the point that a cell of a block starts from. Within a block all points come once, and over the blocks
    /// each cell meets all points; where points are fewer, all come as often as others over the blocks.
    [[nodiscard]] int pointOf(int lane, int block, int cell) const
    {
        const Lane& l = lane_[std::size_t(lane)];
        const int number = (cell ^ (block * 11) ^ int(l.id * 0x9e3779b9u >> 28)) & (kMaxTexelPoints - 1);
        return l.pointCount == kMaxTexelPoints ? number : (block * kMaxTexelPoints + number) % l.pointCount;
    }

private:
    TexelGroup() = default;

    static_assert(kMaxTexelPoints == StratifiedPattern::kBlock);
    static constexpr int kTrianglePoints = kMaxTexelPoints - 1;
    struct Lane {
        uint32_t texel = 0;
        uint32_t id = 0;
        PointMask mask = 0;
        bool behind = false;
        int pointCount = 0;
        TexelPoints points;
    };

    int lanes_ = 0;
    std::array<Lane, kLanes> lane_;
};

/// Texels that send bundles of rays over their hemispheres.
class GatherGroup : public TexelGroup {
public:
    GatherGroup(const PathTracer& paths, const TexelMap& map, std::span<const uint32_t> texels,
                std::span<const PointMask> outside)
        : TexelGroup(paths, map, texels, outside)
    {
        arrange(paths);
    }
    GatherGroup(const PathTracer& paths, const TexelGroup& group) : TexelGroup(group) { arrange(paths); }

    /// A ray's origin with its frame.
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
    /// Whether all points of all texels have the frame of the first one of theirs.
    [[nodiscard]] bool flat() const { return flat_; }

private:
    void arrange(const PathTracer& paths)
    {
        for (int lane = 0; lane < lanes(); ++lane) arrange(paths, lane);
    }
    void arrange(const PathTracer& paths, int lane)
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
            origin.position = paths.rayOrigin(point);
        }
    }

    std::array<std::array<Origin, kMaxTexelPoints>, kLanes> origins_;
    bool flat_ = true;
};

/// All cells of a block.
inline constexpr std::array<uint8_t, StratifiedPattern::kBlock> kAllCells = {0, 1, 2,  3,  4,  5,  6,  7,
                                                                             8, 9, 10, 11, 12, 13, 14, 15};

/// The rays of one block of all texels of a group, in packets of one cell of the pattern each.
struct RayBundle {
    std::array<RTCRayHit8, StratifiedPattern::kBlock> rays;

    /// Sets the origins of the given cells of block `number`, and their frames. Lanes without a texel have another's.
    void place(const GatherGroup& group, int number, std::span<const uint8_t> cells)
    {
        flat_ = group.flat();
        const int any = group.firstActive();
        if (any == group.lanes()) return;
        for (const uint8_t cell : cells) {
            RTCRay8& packet = rays[cell].ray;
            Frames& frame = frames_[flat_ ? 0 : cell];
            const bool setFrame = !flat_ || cell == cells.front();
            for (int lane = 0; lane < TexelGroup::kLanes; ++lane) {
                const int from = group.active(lane) ? lane : any;
                const GatherGroup::Origin& s = group.origin(from, group.pointOf(from, number, cell));
                packet.org_x[lane] = s.position.x;
                packet.org_y[lane] = s.position.y;
                packet.org_z[lane] = s.position.z;
                if (!setFrame) continue;
                const auto l = std::size_t(lane);
                frame.tangent.set(l, s.tangent);
                frame.bitangent.set(l, s.bitangent);
                frame.normal.set(l, s.normal);
                frame.geometricNormal.set(l, s.geometricNormal);
            }
        }
    }

    /// Traces the given cells of block `number`; `seed` separates uses of the same texel. Returns the number of rays.
    int trace(const PathTracer& paths, const StratifiedPattern& pattern, const GatherGroup& group, uint32_t seed,
              int number, std::span<const uint8_t> cells)
    {
        place(group, number, cells);
        alignas(32) embree::LaneMask valid;
        std::array<StratifiedPattern::Block, TexelGroup::kLanes> blocks;
        int active = 0;
        for (int lane = 0; lane < TexelGroup::kLanes; ++lane) {
            valid.lane[lane] = group.active(lane) ? -1 : 0;
            blocks[std::size_t(lane)] = pattern.block(hashCombine(seed, group.id(lane)), number);
            active += group.active(lane) ? 1 : 0;
        }
        std::array<Vec3Lanes<TexelGroup::kLanes>, StratifiedPattern::kBlock> locals;
        for (const uint8_t cell : cells) {
            for (std::size_t lane = 0; lane < TexelGroup::kLanes; ++lane) {
                locals[cell].set(lane, pattern.direction(blocks[lane].bits(cell)));
            }
        }
        for (const uint8_t cell : cells) {
            const Vec3Lanes<TexelGroup::kLanes>& local = locals[cell];
            RTCRayHit8& packet = rays[cell];
            RayTracer::clear(packet.ray);
            const Frames& f = frame(cell);
            Vec3Lanes<TexelGroup::kLanes> direction;
            for (std::size_t l = 0; l < TexelGroup::kLanes; ++l) {
                const vec3 g = f.geometricNormal[l];
                vec3 d = local.x[l] * f.tangent[l] + local.y[l] * f.bitangent[l] + local.z[l] * f.normal[l];
                // As PathTracer::gatherDirection(): never below the surface.
                const float side = glm::dot(d, g);
                d -= (side < 0.0f ? 2.0f * side : 0.0f) * g;
                direction.set(l, d);
            }
            std::copy(direction.x.begin(), direction.x.end(), packet.ray.dir_x);
            std::copy(direction.y.begin(), direction.y.end(), packet.ray.dir_y);
            std::copy(direction.z.begin(), direction.z.end(), packet.ray.dir_z);
            paths.surfaces().intersect(valid, packet);
        }
        return active * int(cells.size());
    }
    /// Of the texels' points that a cell's rays leave from.
    struct Frames {
        Vec3Lanes<TexelGroup::kLanes> tangent;
        Vec3Lanes<TexelGroup::kLanes> bitangent;
        Vec3Lanes<TexelGroup::kLanes> normal;
        Vec3Lanes<TexelGroup::kLanes> geometricNormal;
    };
    [[nodiscard]] const Frames& frame(std::size_t cell) const { return frames_[flat_ ? 0 : cell]; }
    [[nodiscard]] vec3 origin(std::size_t cell, int lane) const
    {
        const RTCRay8& r = rays[cell].ray;
        return {r.org_x[lane], r.org_y[lane], r.org_z[lane]};
    }
    [[nodiscard]] vec3 direction(int cell, int lane) const
    {
        return embree::directionOf(rays[std::size_t(cell)].ray, lane);
    }
    [[nodiscard]] bool hit(int cell, int lane) const
    {
        return rays[std::size_t(cell)].hit.geomID[lane] != RTC_INVALID_GEOMETRY_ID;
    }
    [[nodiscard]] bool behind(int cell, int lane) const { return embree::behind(rays[std::size_t(cell)], lane); }
    [[nodiscard]] RayHit at(int cell, int lane) const
    {
        const RTCRayHit8& r = rays[std::size_t(cell)];
        return {
            hit(cell, lane), behind(cell, lane), r.hit.geomID[lane], r.hit.primID[lane], {r.hit.u[lane], r.hit.v[lane]},
            r.ray.tfar[lane]};
    }

private:
    std::array<Frames, StratifiedPattern::kBlock> frames_;
    bool flat_ = true; ///< all cells have the first one's
};

/// Calls a body for texels 0…count-1 of a list, eight at a time, on all threads: texelAt(i) and maskAt(i) tell which
/// they are and which of their points to use. makeBody() gives each run of texels a body of its own (with its scratch
/// memory): body(group, first, rays), where `first` is the list's number of lane 0. False when cancelled.
template<typename Group, typename TexelAt, typename MaskAt, typename MakeBody>
bool forTexelGroups(const PathTracer& paths, const TexelMap& map, std::size_t count, const TexelAt& texelAt,
                    const MaskAt& maskAt, const Progress& progress, const char* stage, std::atomic<uint64_t>& rayCount,
                    const MakeBody& makeBody)
{
    constexpr std::size_t kGrain = 64;
    return parallelFor(count, kGrain, progress, stage, [&](std::size_t begin, std::size_t end) {
        auto body = makeBody();
        uint64_t rays = 0;
        std::array<uint32_t, TexelGroup::kLanes> texels;
        std::array<PointMask, TexelGroup::kLanes> masks;
        for (std::size_t i = begin; i < end && !progress.cancelled(); i += TexelGroup::kLanes) {
            const std::size_t lanes = std::min(end - i, std::size_t(TexelGroup::kLanes));
            for (std::size_t k = 0; k < lanes; ++k) {
                texels[k] = texelAt(i + k);
                masks[k] = maskAt(i + k);
            }
            body(Group(paths, map, std::span(texels.data(), lanes), std::span(masks.data(), lanes)), i, rays);
        }
        rayCount += rays;
    });
}

} // namespace halflight
