#include "bake/lights/colored_masks.h"

#include "bake/lights/overlaps.h"

#include <algorithm>
#include <cstdint>

namespace halflight {
namespace {

/// Of the texels in a light's reach: a coloured shadow on fewer is not worth two channels.
constexpr float kLeastColored = 0.001f;
constexpr uint32_t kThree = 7; ///< R, G and B of a layer

/// First channels of all lights, most important first, so that lights that overlap share none. Coloured ones choose
/// first, and take three. Empty where a light finds none.
std::vector<int> channelsWith(const Graph& overlaps, const std::vector<uint8_t>& colored, int channels)
{
    std::vector<int> result(overlaps.size(), -1);
    std::vector<uint32_t> taken(overlaps.size(), 0); // bits of the channels of those that it overlaps
    for (const bool three : {true, false}) {
        const uint32_t wanted = three ? kThree : 1u;
        const int step = three ? kLayerChannels : 1;
        for (std::size_t i = 0; i < overlaps.size(); ++i) {
            if ((colored[i] != 0) != three) continue;
            int channel = 0;
            while (channel < channels && (taken[i] & (wanted << channel)) != 0) channel += step;
            if (channel >= channels) return {};
            result[i] = channel;
            for (const int other : overlaps[i]) taken[std::size_t(other)] |= wanted << channel;
        }
    }
    return result;
}

} // namespace

ColoredMasks colorMasks(Scene& scene, std::span<const float> shares, int mostLayers)
{
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < scene.lights.size(); ++i)
        if (scene.lights[i].baking.occlusionMaskChannel >= 0) order.push_back(i);
    std::ranges::stable_sort(
        order, [&](std::size_t a, std::size_t b) { return moreImportant(scene.lights[a], scene.lights[b]); });
    std::vector<const Light*> lights;
    for (const std::size_t i : order) lights.push_back(&scene.lights[i]);
    const Graph overlaps = overlapsOf(lights);

    ColoredMasks result;
    std::vector<uint8_t> colored(lights.size(), 0);
    std::vector<int> channels;
    for (std::size_t i = 0; i < lights.size(); ++i) {
        if (!(shares[order[i]] > kLeastColored)) continue;
        colored[i] = 1;
        std::vector<int> found = channelsWith(overlaps, colored, mostLayers * kLayerChannels);
        if (!found.empty()) {
            channels = std::move(found);
            continue;
        }
        colored[i] = 0;
        result.leftGray.push_back(lights[i]->name);
    }
    result.any = !channels.empty();
    for (std::size_t i = 0; result.any && i < order.size(); ++i) {
        BakingOutput& baking = scene.lights[order[i]].baking;
        baking.occlusionMaskChannel = channels[i];
        baking.coloredMask = colored[i] != 0;
    }
    return result;
}

} // namespace halflight
