#include "halflight/scene/baked_scene.h"

#include <algorithm>

namespace halflight {

int maskLayersOf(const Scene& scene)
{
    int layers = 1;
    for (const Light& light : scene.lights)
        layers = std::max(layers, light.baking.occlusionMaskChannel / kLayerChannels + 1);
    return layers;
}

bool hasColoredMasks(const Scene& scene)
{
    return std::ranges::any_of(scene.lights, [](const Light& light) { return light.baking.coloredMask; });
}

ivec2 maskPageSize(const BakedScene& baked)
{
    const auto page = std::find_if(baked.shadowmasks.begin(), baked.shadowmasks.end(),
                                   [](const ImageRgba8& mask) { return !mask.empty(); });
    return page == baked.shadowmasks.end() ? ivec2(0) : page->size();
}

} // namespace halflight
