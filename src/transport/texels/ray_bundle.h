#pragma once
// The gather rays of one sample block of eight texels.

#include "transport/texels/texel_group.h"
#include "transport/trace/lanes.h"

#include "halflight/shading/gather.h"

namespace halflight {

inline constexpr std::array<uint8_t, StratifiedPattern::kBlock> kAllStrata = {0, 1, 2,  3,  4,  5,  6,  7,
                                                                              8, 9, 10, 11, 12, 13, 14, 15};

/// Rays of one block of all texels of a group, and what they hit. The rays of one stratum are a batch: they are
/// coherent.
struct RayBundle {
    template<typename T> using OfStratum = std::array<T, kLanes>;
    std::array<OfStratum<Ray>, StratifiedPattern::kBlock> rays;    ///< by stratum and lane
    std::array<OfStratum<RayHit>, StratifiedPattern::kBlock> hits; ///< the same

    /// Traces the given strata of block `number`; uses of one texel differ in `seed`. Returns the number of rays.
    int trace(const PathTracer& paths, const StratifiedPattern& pattern, const GatherGroup& group, uint32_t seed,
              int number, std::span<const uint8_t> strata)
    {
        place(group, number, strata);
        std::array<StratifiedPattern::Block, kLanes> blocks;
        int active = 0;
        for (int lane = 0; lane < kLanes; ++lane) {
            blocks[std::size_t(lane)] = pattern.block(hashCombine(seed, group.id(lane)), number);
            active += group.active(lane) ? 1 : 0;
        }
        std::array<Vec3Lanes, StratifiedPattern::kBlock> locals;
        for (const uint8_t stratum : strata) {
            for (std::size_t lane = 0; lane < kLanes; ++lane) {
                locals[stratum].set(lane, pattern.direction(blocks[lane].bits(stratum)));
            }
        }
        for (const uint8_t stratum : strata) {
            const Vec3Lanes& local = locals[stratum];
            const Frames& f = frame(stratum);
            Vec3Lanes direction;
            for (std::size_t l = 0; l < kLanes; ++l) {
                const vec3 g = f.geometricNormal[l];
                const vec3 d = local.x[l] * f.tangent[l] + local.y[l] * f.bitangent[l] + local.z[l] * f.normal[l];
                direction.set(l, shading::outOfSurface(d, g));
            }
            for (std::size_t l = 0; l < kLanes; ++l) {
                Ray& ray = rays[stratum][l];
                ray.direction = direction[l];
                ray.tMax = group.active(int(l)) ? kInfinity : -1.0f;
            }
            paths.surfaces().nearest(rays[stratum], hits[stratum]);
        }
        return active * int(strata.size());
    }

    /// Frames of the points that a stratum's rays start from.
    struct Frames {
        Vec3Lanes tangent;
        Vec3Lanes bitangent;
        Vec3Lanes normal;
        Vec3Lanes geometricNormal;
    };
    [[nodiscard]] const Frames& frame(std::size_t stratum) const { return frames_[flat_ ? 0 : stratum]; }
    [[nodiscard]] vec3 origin(std::size_t stratum, int lane) const { return rays[stratum][std::size_t(lane)].origin; }
    [[nodiscard]] vec3 direction(int stratum, int lane) const
    {
        return rays[std::size_t(stratum)][std::size_t(lane)].direction;
    }
    [[nodiscard]] const RayHit& hit(int stratum, int lane) const
    {
        return hits[std::size_t(stratum)][std::size_t(lane)];
    }

private:
    /// Sets origins and frames of the given strata of block `number`. Lanes without a texel get those of another lane.
    void place(const GatherGroup& group, int number, std::span<const uint8_t> strata)
    {
        flat_ = group.flat();
        const int any = group.firstActive();
        if (any == group.lanes()) return;
        for (const uint8_t stratum : strata) {
            Frames& frame = frames_[flat_ ? 0 : stratum];
            const bool setFrame = !flat_ || stratum == strata.front();
            for (int lane = 0; lane < kLanes; ++lane) {
                const int from = group.active(lane) ? lane : any;
                const GatherGroup::Origin& s = group.origin(from, group.pointOf(from, number, stratum));
                const auto l = std::size_t(lane);
                rays[stratum][l].origin = s.position;
                if (!setFrame) continue;
                frame.tangent.set(l, s.tangent);
                frame.bitangent.set(l, s.bitangent);
                frame.normal.set(l, s.normal);
                frame.geometricNormal.set(l, s.geometricNormal);
            }
        }
    }

    std::array<Frames, StratifiedPattern::kBlock> frames_;
    bool flat_ = true; ///< all strata have the frames of stratum 0
};

} // namespace halflight
