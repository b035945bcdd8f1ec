#include "transport/shadows/colored_shadows.h"

#include "transport/shadows/shadow_rays.h"

#include <algorithm>
#include <atomic>
#include <utility>
#include <vector>

namespace halflight {
namespace {

/// Texels that are looked at, of all: of the 0.1 % that give a light a coloured mask, 32.
constexpr std::size_t kMostTexels = 32768;
/// Steps of a mask's values: the eye sees none of a smaller difference between its channels.
constexpr float kSameColor = 2.0f / 255.0f;

struct Counts {
    std::atomic<uint32_t> reached{0};
    std::atomic<uint32_t> colored{0};
};

} // namespace

Status traceColoredShadows(const PathTracer& paths, const StratifiedPattern& pattern, const TexelMap& map,
                           uint32_t seed, std::span<float> shares, const Progress& progress,
                           std::atomic<uint64_t>& rays)
{
    std::ranges::fill(shares, 0.0f);
    if (!paths.surfaces().anyTinted()) return {};
    std::vector<std::size_t> lights;
    std::vector<ShadowSource> sources;
    for (std::size_t i = 0; i < shares.size(); ++i) {
        const PunctualLight& light = paths.light().lights()[i];
        if (light.channel < 0 || !light.castShadows) continue;
        lights.push_back(i);
        sources.push_back(
            {LightReach(std::vector<const PunctualLight*>{&light}), light.maskOfLight, hashCombine(seed, uint32_t(i))});
    }
    std::vector<Counts> counts(sources.size());
    const std::size_t asked = std::min(map.texels.size(), kMostTexels);
    const auto texelOf = [&](std::size_t i) { return uint32_t(i * map.texels.size() / asked); };
    const Status traced = forTexelGroups(
        paths.surfaces(), asked, texelOf,
        [&](std::span<const uint32_t> texels) { return ShadowGroup(paths, map, texels, PointUse::All); }, progress,
        "coloured shadows", rays,
        [&] {
            return [&](const ShadowGroup& group, std::size_t, uint64_t& groupRays) {
                for (std::size_t s = 0; s < sources.size(); ++s) {
                    const ShadowRays::Sums sums =
                        ShadowRays(paths, pattern, sources[s]).trace(group, ~0u, 0, groupRays);
                    for (std::size_t lane = 0; lane < std::size_t(group.lanes()); ++lane) {
                        if (!sums.lit[lane].any()) continue;
                        const vec3 color = sums.colors[lane] / sums.lit[lane].all;
                        const float differs =
                            std::max({color.x, color.y, color.z}) - std::min({color.x, color.y, color.z});
                        ++counts[s].reached;
                        if (differs > kSameColor) ++counts[s].colored;
                    }
                }
            };
        });
    if (!traced) return traced;
    for (std::size_t s = 0; s < sources.size(); ++s)
        shares[lights[s]] = float(counts[s].colored) / float(std::max(uint32_t(counts[s].reached), 1u));
    return {};
}

} // namespace halflight
