#pragma once
// Rays towards punctual lights, in bundles: for shadowmasks and for direct light that is baked.

#include "bake_cpu/texel_group.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

namespace halflight {

/// Texels whose batches of points begin here and there: where a shadow's edge along a row of texels slips between the
/// points of one, it meets its neighbours'.
class ShadowGroup : public TexelGroup {
public:
    ShadowGroup(const PathTracer& paths, const TexelMap& map, std::span<const uint32_t> texels,
                std::span<const PointMask> outside, int batch = 0)
        : TexelGroup(paths, map, texels, outside, [&](uint32_t id) { return batch + firstBatch(id); })
    {}

    /// One of those, among many, whose points' mean is nearest to the middle of the square: they have the light of a
    /// whole texel where that changes across it.
    static int firstBatch(uint32_t id)
    {
        constexpr int kMany = 32768;
        constexpr std::size_t kFew = 256;
        static const std::vector<std::pair<float, int>> few = [] {
            std::vector<std::pair<float, int>> batches;
            for (int batch = 0; batch < kMany; ++batch) {
                vec2 sum(0.0f);
                for (int i = 0; i < kMaxTexelPoints; ++i) sum += r2Point(batch * kMaxTexelPoints + i) - 0.5f;
                batches.emplace_back(glm::length(sum), batch);
            }
            std::partial_sort(batches.begin(), batches.begin() + kFew, batches.end());
            batches.resize(kFew);
            batches.shrink_to_fit();
            return batches;
        }();
        return few[hashPcg(id) % kFew].second;
    }
};

/// Samples come in halves of eight, each at points of the texel of its own: two halves use up a batch of texelPoints().
/// So shadow edges are antialiased by as many points as there are rays, and lights without extent gain from more rays
/// like the others.
class ShadowRays {
public:
    static constexpr int kHalf = 8;

    ShadowRays(const PathTracer& paths, const GatherPattern& pattern, uint32_t seed)
        : paths_(paths), pattern_(pattern), seed_(seed)
    {}

    /// Halves that `samples` rays for each texel come to.
    static int halvesOf(int samples) { return std::max(1, (samples + kHalf - 1) / kHalf); }

    /// The light that a point looks at, null for none, and what its ray counts.
    struct Aim {
        const PunctualLight* light = nullptr;
        float weight = 1.0f;
    };

    /// One half for all active lanes that `wanted` names (a bit each), from the points of its batch. aimOf(point) tells
    /// where to look; result(lane, share, weight) is called for each sample with a light: what of its light arrives.
    template<typename AimOf, typename Result> void trace(const TexelGroup& group, uint32_t wanted, int half,
                                                         const AimOf& aimOf, const Result& result, uint64_t& rays) const
    {
        std::array<Aim, TexelGroup::kLanes> aims;
        for (int i = 0; i < kHalf; ++i) {
            ShadowPacket packet(paths_);
            for (int lane = 0; lane < TexelGroup::kLanes; ++lane) {
                const auto l = std::size_t(lane);
                aims[l] = {};
                if (!group.active(lane) || ((wanted >> lane) & 1u) == 0) continue;
                const SurfacePoint& point = group.point(lane, half * kHalf + i);
                aims[l] = aimOf(point);
                if (aims[l].light == nullptr) continue;
                const vec2 disc = pattern_.disc(hashCombine(seed_, group.id(lane)), uint32_t(half * kHalf + i));
                packet.add(lane, *aims[l].light, point, disc, rays);
            }
            const std::array<float, TexelGroup::kLanes> shares = packet.trace();
            for (int lane = 0; lane < TexelGroup::kLanes; ++lane) {
                const Aim& aim = aims[std::size_t(lane)];
                if (aim.light != nullptr) result(lane, shares[std::size_t(lane)], aim.weight);
            }
        }
    }

private:
    const PathTracer& paths_;
    const GatherPattern& pattern_;
    uint32_t seed_;
};

} // namespace halflight
