#pragma once
// Rays towards punctual lights, in bundles: for shadowmasks and for direct light that is baked.

#include "bake_cpu/shadows/light_reach.h"
#include "bake_cpu/texels/ray_bundle.h"

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

/// Between what shares the rays to one light arrived from a texel.
struct LitRange {
    static constexpr int kLit = 254; ///< of a ray all of whose light arrives
    /// Rays that differ no more than this find the same: light through one pane of glass, say.
    static constexpr int kAlike = 8;
    uint8_t least = kLit;
    uint8_t most = 0;

    void add(float share)
    {
        const auto value = uint8_t(share * float(kLit) + 0.5f);
        least = std::min(least, value);
        most = std::max(most, value);
    }
    /// Takes in what another's rays found.
    void add(LitRange other)
    {
        least = std::min(least, other.least);
        most = std::max(most, other.most);
    }
    /// Whether rays found one thing and others another.
    [[nodiscard]] bool mixed() const { return int(most) - int(least) > kAlike; }
};

/// Of some rays to one light.
struct LitSum {
    float lit = 0.0f; ///< of `all`, what arrives
    float all = 0.0f; ///< weights of the rays
    LitRange range;

    /// A ray that counts so much, of whose light a share arrives.
    void add(float share, float weight)
    {
        lit += weight * share;
        all += weight;
        range.add(share);
    }
};

/// A light, or several that never meet.
struct ShadowSource {
    LightReach lights;
    /// Only points that would be lit look, those that face the light, which is not dark there; and their rays count as
    /// much as they would receive.
    bool lit = false;
    uint32_t seed = 0;

    /// The light that a point looks at, null for none, and what its ray counts.
    struct Aim {
        const PunctualLight* light = nullptr;
        float weight = 1.0f;
    };
    [[nodiscard]] Aim aimOf(const SurfacePoint& point) const
    {
        if (!lit) return {lights.at(point.position), 1.0f};
        for (const PunctualLight* light : lights.lights()) {
            constexpr float kMost = 1.0e30f; // so that sums are numbers
            const float weight = std::min(luminance(light->irradianceAt(point.position, point.normal)), kMost);
            if (weight > 0.0f) return {light, weight};
        }
        return {};
    }
};

/// Samples come in halves of eight, each at points of the texel of its own: two halves use up a batch of texelPoints().
/// So shadow edges are antialiased by as many points as there are rays, and lights without extent gain from more rays
/// like the others.
class ShadowRays {
public:
    static constexpr int kHalf = 8;

    ShadowRays(const PathTracer& paths, const StratifiedPattern& pattern, const ShadowSource& source)
        : paths_(paths), pattern_(pattern), source_(source)
    {}

    /// Halves that `samples` rays for each texel come to.
    static int halvesOf(int samples) { return std::max(1, (samples + kHalf - 1) / kHalf); }

    /// One half for all active lanes that `wanted` names (a bit each), from the points of its batch. By lane.
    using Sums = std::array<LitSum, TexelGroup::kLanes>;
    Sums trace(const TexelGroup& group, uint32_t wanted, int half, uint64_t& rays) const
    {
        Sums sums;
        std::array<ShadowSource::Aim, TexelGroup::kLanes> aims;
        for (int i = 0; i < kHalf; ++i) {
            ShadowPacket packet(paths_);
            for (int lane = 0; lane < TexelGroup::kLanes; ++lane) {
                const auto l = std::size_t(lane);
                aims[l] = {};
                if (!group.active(lane) || ((wanted >> lane) & 1u) == 0) continue;
                const SurfacePoint& point = group.point(lane, half * kHalf + i);
                aims[l] = source_.aimOf(point);
                if (aims[l].light == nullptr) continue;
                const vec2 disc = pattern_.disc(hashCombine(source_.seed, group.id(lane)), uint32_t(half * kHalf + i));
                packet.add(lane, *aims[l].light, point, disc, rays);
            }
            const std::array<float, TexelGroup::kLanes> shares = packet.trace();
            for (int lane = 0; lane < TexelGroup::kLanes; ++lane) {
                const ShadowSource::Aim& aim = aims[std::size_t(lane)];
                if (aim.light != nullptr) sums[std::size_t(lane)].add(shares[std::size_t(lane)], aim.weight);
            }
        }
        return sums;
    }

private:
    const PathTracer& paths_;
    const StratifiedPattern& pattern_;
    const ShadowSource& source_;
};

} // namespace halflight
