#include "transport/shadows/mask_layer.h"

#include "halflight/base/parallel.h"

#include <algorithm>
#include <vector>

namespace halflight {
namespace {

/// Lights that share a channel: at most one of them reaches any point.
struct ChannelLights {
    int channel = 0;
    bool colored = false; ///< of three channels, from this one on
    std::vector<const PunctualLight*> lights;

    [[nodiscard]] int count() const { return colored ? 3 : 1; }
    [[nodiscard]] bool maskOfLight() const { return lights.front()->maskOfLight; }
};

/// Of a layer. Lights with coloured masks are apart from those that are grey in the same channel elsewhere.
std::vector<ChannelLights> channelsOf(std::span<const PunctualLight> lights, int layer)
{
    std::vector<ChannelLights> result;
    const int first = layer * kLayerChannels;
    for (int channel = first; channel < first + kLayerChannels; ++channel) {
        for (const bool colored : {false, true}) {
            ChannelLights owners{channel, colored, {}};
            for (const PunctualLight& light : lights)
                if (light.channel == channel && light.coloredMask == colored) owners.lights.push_back(&light);
            if (!owners.lights.empty()) result.push_back(std::move(owners));
        }
    }
    return result;
}

} // namespace

Status traceMaskLayer(const ShadowPass& pass, uint32_t seed, int layer, std::span<vec4> out)
{
    std::fill(out.begin(), out.end(), vec4(1.0f));
    const std::vector<ChannelLights> channels = channelsOf(pass.paths.light().lights(), layer);
    std::vector<ShadowSource> sources;
    bool colored = false;
    int timesOnEdges = pass.timesOnEdges;
    for (const ChannelLights& owners : channels) {
        if (owners.maskOfLight()) timesOnEdges = kTimesOnLightEdges;
        colored = colored || owners.colored;
        sources.push_back(
            {LightReach(owners.lights), owners.maskOfLight(), hashCombine(seed, uint32_t(owners.channel))});
    }
    std::vector<LitSum> counts;
    std::vector<vec3> colors; // sums of weight times transmittance; empty in scenes without coloured glass
    if (Status s = traceShadows(pass.withEdges(timesOnEdges), sources, counts, colored ? &colors : nullptr); !s)
        return s;
    forEachIndex(pass.texels.size(), [&](std::size_t i) {
        for (std::size_t c = 0; c < channels.size(); ++c) {
            const std::size_t place = i * channels.size() + c;
            const LitSum& count = counts[place];
            // A mask of light is 0 where the light would not illuminate the texel; else it stays 1.
            if (!count.any() && !sources[c].lit) continue;
            vec3 passed(count.any() ? count.share() : 0.0f);
            if (channels[c].colored && !colors.empty() && count.any())
                passed = glm::min(colors[place] / count.all, vec3(1.0f));
            for (int k = 0; k < channels[c].count(); ++k) out[i][channels[c].channel % kLayerChannels + k] = passed[k];
        }
    });
    return {};
}

} // namespace halflight
