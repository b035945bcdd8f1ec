#pragma once
// The gather rays of one sample block of eight texels.

#include "bake_cpu/texels/texel_group.h"
#include "bake_cpu/trace/lanes.h"

namespace halflight {

inline constexpr std::array<uint8_t, StratifiedPattern::kBlock> kAllStrata = {0, 1, 2,  3,  4,  5,  6,  7,
                                                                              8, 9, 10, 11, 12, 13, 14, 15};

/// Rays of one block of all texels of a group. The rays of one stratum are a packet: they are coherent.
struct RayBundle {
    std::array<RTCRayHit8, StratifiedPattern::kBlock> rays; ///< by stratum

    /// Sets origins and frames of the given strata of block `number`. Lanes without a texel get those of another lane.
    void place(const GatherGroup& group, int number, std::span<const uint8_t> strata)
    {
        flat_ = group.flat();
        const int any = group.firstActive();
        if (any == group.lanes()) return;
        for (const uint8_t stratum : strata) {
            RTCRay8& packet = rays[stratum].ray;
            Frames& frame = frames_[flat_ ? 0 : stratum];
            const bool setFrame = !flat_ || stratum == strata.front();
            for (int lane = 0; lane < TexelGroup::kLanes; ++lane) {
                const int from = group.active(lane) ? lane : any;
                const GatherGroup::Origin& s = group.origin(from, group.pointOf(from, number, stratum));
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

    /// Traces the given strata of block `number`; uses of one texel differ in `seed`. Returns the number of rays.
    int trace(const PathTracer& paths, const StratifiedPattern& pattern, const GatherGroup& group, uint32_t seed,
              int number, std::span<const uint8_t> strata)
    {
        place(group, number, strata);
        alignas(32) embree::LaneMask valid;
        std::array<StratifiedPattern::Block, TexelGroup::kLanes> blocks;
        int active = 0;
        for (int lane = 0; lane < TexelGroup::kLanes; ++lane) {
            valid.lane[lane] = group.active(lane) ? -1 : 0;
            blocks[std::size_t(lane)] = pattern.block(hashCombine(seed, group.id(lane)), number);
            active += group.active(lane) ? 1 : 0;
        }
        std::array<Vec3Lanes<TexelGroup::kLanes>, StratifiedPattern::kBlock> locals;
        for (const uint8_t stratum : strata) {
            for (std::size_t lane = 0; lane < TexelGroup::kLanes; ++lane) {
                locals[stratum].set(lane, pattern.direction(blocks[lane].bits(stratum)));
            }
        }
        for (const uint8_t stratum : strata) {
            const Vec3Lanes<TexelGroup::kLanes>& local = locals[stratum];
            RTCRayHit8& packet = rays[stratum];
            embree::clear(packet.ray);
            const Frames& f = frame(stratum);
            Vec3Lanes<TexelGroup::kLanes> direction;
            for (std::size_t l = 0; l < TexelGroup::kLanes; ++l) {
                const vec3 g = f.geometricNormal[l];
                vec3 d = local.x[l] * f.tangent[l] + local.y[l] * f.bitangent[l] + local.z[l] * f.normal[l];
                // As PathTracer::gatherDirection(): reflected out of the surface.
                const float side = glm::dot(d, g);
                d -= (side < 0.0f ? 2.0f * side : 0.0f) * g;
                direction.set(l, d);
            }
            std::copy(direction.x.begin(), direction.x.end(), packet.ray.dir_x);
            std::copy(direction.y.begin(), direction.y.end(), packet.ray.dir_y);
            std::copy(direction.z.begin(), direction.z.end(), packet.ray.dir_z);
            paths.surfaces().intersect(valid, packet);
        }
        return active * int(strata.size());
    }

    /// Frames of the points that a stratum's rays start from.
    struct Frames {
        Vec3Lanes<TexelGroup::kLanes> tangent;
        Vec3Lanes<TexelGroup::kLanes> bitangent;
        Vec3Lanes<TexelGroup::kLanes> normal;
        Vec3Lanes<TexelGroup::kLanes> geometricNormal;
    };
    [[nodiscard]] const Frames& frame(std::size_t stratum) const { return frames_[flat_ ? 0 : stratum]; }
    [[nodiscard]] vec3 origin(std::size_t stratum, int lane) const
    {
        const RTCRay8& r = rays[stratum].ray;
        return {r.org_x[lane], r.org_y[lane], r.org_z[lane]};
    }
    [[nodiscard]] vec3 direction(int stratum, int lane) const
    {
        return embree::directionOf(rays[std::size_t(stratum)].ray, lane);
    }
    [[nodiscard]] bool found(int stratum, int lane) const { return embree::found(rays[std::size_t(stratum)], lane); }
    [[nodiscard]] float distance(int stratum, int lane) const { return rays[std::size_t(stratum)].ray.tfar[lane]; }
    [[nodiscard]] RayHit hit(int stratum, int lane) const
    {
        const RTCRayHit8& r = rays[std::size_t(stratum)];
        return {found(stratum, lane), embree::hitBack(r, lane),       r.hit.geomID[lane],
                r.hit.primID[lane],   embree::barycentricOf(r, lane), r.ray.tfar[lane]};
    }

private:
    std::array<Frames, StratifiedPattern::kBlock> frames_;
    bool flat_ = true; ///< all strata have the frames of stratum 0
};

} // namespace halflight
