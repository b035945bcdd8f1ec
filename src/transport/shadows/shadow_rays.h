#pragma once
// Packets of shadow rays from texels to lights.

#include "transport/sample/light_reach.h"
#include "transport/sample/shadow_packet.h"
#include "transport/texels/texel_group.h"

#include <algorithm>
#include <array>
#include <span>
#include <utility>
#include <vector>

namespace halflight {

/// Texels that start at different batches of texelPoints(). A shadow edge along a row of texels may pass between the
/// points of one batch, but not between those of all neighbours.
class ShadowGroup : public TexelGroup {
public:
    ShadowGroup(const PathTracer& paths, const TexelMap& map, std::span<const uint32_t> texels, PointUse use,
                int batch = 0)
        : TexelGroup(paths, map, texels, use, [&](uint32_t id) { return batch + firstBatch(id); })
    {
        for (int lane = 0; lane < lanes(); ++lane)
            for (int p = 0; p < pointCount(lane); ++p) bounds_.extend(points(lane)[std::size_t(p)].position);
    }
    /// Of all points.
    [[nodiscard]] const Bounds& bounds() const { return bounds_; }

    /// One of the 256 batches, of 32768, whose mean point is closest to the texel's centre: their mean light is that of
    /// the whole texel to first order. Neighbours have different ones.
    static int firstBatch(uint32_t id) { return int(firstBatches()[hashPcg(id) % firstBatches().size()]); }
    static std::span<const uint32_t> firstBatches()
    {
        constexpr int kMany = 32768;      // batches that are compared
        constexpr std::size_t kFew = 256; // batches that neighbours choose among
        static const std::vector<uint32_t> few = [] {
            std::vector<std::pair<float, int>> batches;
            for (int batch = 0; batch < kMany; ++batch) {
                vec2 sum(0.0f);
                for (int i = 0; i < kMaxTexelPoints; ++i) sum += r2Point(batch * kMaxTexelPoints + i) - 0.5f;
                batches.emplace_back(glm::length(sum), batch);
            }
            std::partial_sort(batches.begin(), batches.begin() + kFew, batches.end());
            std::vector<uint32_t> numbers;
            for (std::size_t i = 0; i < kFew; ++i) numbers.push_back(uint32_t(batches[i].second));
            return numbers;
        }();
        return few;
    }

private:
    Bounds bounds_;
};

/// Least and largest transmittance of a texel's rays to one light.
struct LitRange {
    static constexpr int kLit = 254; ///< transmittance 1
    /// Rays that differ by at most this agree: all pass through the same pane of glass, for example.
    static constexpr int kAlike = 8;
    uint8_t least = kLit;
    uint8_t most = 0;

    void add(float transmittance)
    {
        const auto value = uint8_t(transmittance * float(kLit) + 0.5f);
        least = std::min(least, value);
        most = std::max(most, value);
    }
    void add(LitRange other)
    {
        least = std::min(least, other.least);
        most = std::max(most, other.most);
    }
    [[nodiscard]] bool any() const { return least <= most; }
    [[nodiscard]] bool mixed() const { return int(most) - int(least) > kAlike; }
    /// Whether ranges of which this is true agree with one another.
    [[nodiscard]] bool isLit() const { return int(least) >= kLit - kAlike; }
    [[nodiscard]] bool isDark() const { return int(most) <= kAlike; }
};

/// Weighted sum of the transmittances of some rays to one light; of coloured ones their luminance counts.
struct LitSum {
    float lit = 0.0f;
    float all = 0.0f; ///< sum of weights
    LitRange range;

    void add(float transmittance, float weight)
    {
        lit += weight * transmittance;
        all += weight;
        range.add(transmittance);
    }
    void add(const LitSum& other)
    {
        lit += other.lit;
        all += other.all;
        range.add(other.range);
    }
    [[nodiscard]] bool any() const { return all > 0.0f; }
    [[nodiscard]] bool mixed() const { return range.mixed(); }
    [[nodiscard]] float share() const { return any() ? std::min(lit / all, 1.0f) : 1.0f; }
};

/// A light, or several of which at most one reaches any point.
struct ShadowSource {
    LightReach lights;
    /// Only points that the light would illuminate trace rays, with their unshadowed irradiance as weight. Else all
    /// points do, with weight 1, or by the share that a ray has in an area light's irradiance.
    bool lit = false;
    uint32_t seed = 0;

    /// The point, on the side that faces the light if the texel is that of both sides of a sheet.
    [[nodiscard]] SurfacePoint facing(const BakeGeometry& geometry, const SurfacePoint& point) const
    {
        if (!sharesTexels(geometry, point.triangle)) return point;
        const PunctualLight* light = lit ? lights.lights().front() : lights.at(point.position);
        return light != nullptr && isBehindSheet(geometry, point, light->towards(point.position)) ? flipped(point)
                                                                                                  : point;
    }

    /// Masks are of the side that faces the light; light is of both sides in mean texels alone.
    [[nodiscard]] bool sharesTexels(const BakeGeometry& geometry, uint32_t triangle) const
    {
        return lit ? geometry.hasMeanTexels(triangle) : geometry.sharesTexels(triangle);
    }

    struct Target {
        const PunctualLight* light = nullptr;
        float weight = 1.0f;
    };
    /// The light that a point traces a ray to, if any; `disc` chooses the ray.
    [[nodiscard]] Target targetOf(const SurfacePoint& point, vec2 disc) const
    {
        if (!lit) {
            const PunctualLight* light = lights.at(point.position);
            if (light == nullptr) return {};
            const float weight = shading::maskRayWeight(*light, point.position, point.normal, disc);
            return weight > 0.0f ? Target{light, weight} : Target{};
        }
        for (const PunctualLight* light : lights.lights()) {
            const float weight = shading::irradianceRayWeight(*light, point.position, point.normal, disc);
            if (weight > 0.0f) return {light, weight};
        }
        return {};
    }
};

/// Most sources of one pass.
constexpr std::size_t kMaxShadowSources = 32;

/// Traces half-batches of eight rays, each ray from its own point of the texel. So shadow edges are antialiased by as
/// many points as there are rays, for lights without extent too.
class ShadowRays {
public:
    static constexpr int kHalf = 8;

    ShadowRays(const PathTracer& paths, const StratifiedPattern& pattern, const ShadowSource& source)
        : paths_(paths), pattern_(pattern), source_(source)
    {}

    /// Half-batches of `samples` rays.
    static int halvesOf(int samples) { return std::max(1, (samples + kHalf - 1) / kHalf); }

    /// One half-batch of all active lanes in `wanted` (a bit each), from the points of the group. By lane.
    struct Sums {
        std::array<LitSum, kLanes> lit;
        std::array<vec3, kLanes> colors{}; ///< sums of weight times transmittance, by colour
    };
    Sums trace(const ShadowGroup& group, uint32_t wanted, int half, uint64_t& rays) const
    {
        Sums sums;
        if (!source_.lights.mayReach(group.bounds())) return sums;
        const bool colored = paths_.surfaces().anyTinted();
        std::array<ShadowSource::Target, kLanes> targets;
        for (int i = 0; i < kHalf; ++i) {
            ShadowPacket packet(paths_);
            for (int lane = 0; lane < kLanes; ++lane) {
                const auto l = std::size_t(lane);
                targets[l] = {};
                if (!group.active(lane) || ((wanted >> lane) & 1u) == 0) continue;
                const SurfacePoint point =
                    source_.facing(paths_.surfaces().geometry(), group.point(lane, half * kHalf + i));
                const vec2 disc = pattern_.disc(hashCombine(source_.seed, group.id(lane)), uint32_t(half * kHalf + i));
                targets[l] = source_.targetOf(point, disc);
                if (targets[l].light == nullptr) continue;
                packet.add(lane, *targets[l].light, point, disc, rays);
            }
            const std::array<vec3, kLanes> transmittance = packet.trace();
            for (std::size_t lane = 0; lane < kLanes; ++lane) {
                const ShadowSource::Target& target = targets[lane];
                if (target.light == nullptr) continue;
                sums.lit[lane].add(grayOf(transmittance[lane]), target.weight);
                if (colored) sums.colors[lane] += target.weight * transmittance[lane];
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
