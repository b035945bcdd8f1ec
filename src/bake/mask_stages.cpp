#include "bake/mask_stages.h"

#include "bake/pages/dilate.h"
#include "bake/pages/encode.h"
#include "bake/pages/mask_field.h"

#include "halflight/base/memory.h"

#include <algorithm>
#include <utility>

namespace halflight {

std::vector<ImageRgba8> maskPages(const CachedIntegrator& cached, const std::vector<uint8_t>& valid,
                                  const std::vector<SeamSample>& seams, std::vector<vec4> mask, int firstDistance,
                                  std::span<MaskChannel, kLayerChannels> channels)
{
    fillInvalid(cached.geometry, cached.map, valid, mask);
    const bool distances = firstDistance < kLayerChannels;
    if (distances) std::ranges::copy(maskToDistances(cached.map, mask, firstDistance), channels.begin());
    std::vector<ImageRgba32f> pages = dilate(cached.map, mask, kDilationRings, distances);
    release(mask);
    stitchSeams(cached.map, seams, maskSeamWeights(seams, pages), pages, !distances);
    return encodeShadowmask(pages);
}

namespace {

/// Empties the pages of a mask layer whose lights light every texel.
void leaveOutLitPages(const TexelMap& map, std::vector<ImageRgba8>& pages)
{
    std::vector<uint8_t> shadowed(pages.size(), 0);
    for (const Texel& texel : map.texels)
        if (pages[texel.page](texel.x, texel.y) != u8vec4(255)) shadowed[texel.page] = 1;
    for (std::size_t page = 0; page < pages.size(); ++page)
        if (shadowed[page] == 0) pages[page] = {};
}

/// Channels of a layer before it hold attenuation: all of them where no distances are asked for, and the three of
/// lights with coloured masks (S35), which the distance to an edge says nothing of.
int firstDistanceOf(const Scene& scene, MaskEncoding encoding, int layer)
{
    const bool colored = std::ranges::any_of(scene.lights, [&](const Light& light) {
        return light.baking.coloredMask && light.baking.occlusionMaskChannel == layer * kLayerChannels;
    });
    return encoding != MaskEncoding::Distance ? kLayerChannels : (colored ? 3 : 0);
}

/// Pages of a mask layer, into the baked scene.
void maskPagesStage(const BakeRun& run, const CachedIntegrator& cached, const std::vector<uint8_t>& valid,
                    const std::vector<SeamSample>& seams, int layer, std::vector<vec4> mask, BakeReport& report)
{
    BakedScene& baked = run.baked();
    StageTimer timer(report, "mask pages");
    const int firstDistance = firstDistanceOf(baked.scene, run.settings.maskEncoding, layer);
    const std::span<MaskChannel, kLayerChannels> channels(&baked.maskChannels[std::size_t(layer * kLayerChannels)],
                                                          kLayerChannels);
    std::vector<ImageRgba8> pages = maskPages(cached, valid, seams, std::move(mask), firstDistance, channels);
    if (baked.maskLayers > 1) leaveOutLitPages(cached.map, pages);
    for (std::size_t page = 0; page < pages.size(); ++page)
        baked.shadowmasks[page * std::size_t(baked.maskLayers) + std::size_t(layer)] = std::move(pages[page]);
    timer.finish();
}

} // namespace

Status shadowmaskStage(const BakeRun& run, const CachedIntegrator& cached, const std::vector<uint8_t>& valid,
                       const std::vector<SeamSample>& seams, BakeReport& pagesReport, Background& pages)
{
    BakedScene& baked = run.baked();
    if (run.settings.mode != MixedLightingMode::Shadowmask || !hasMask(baked.scene, run.settings.mode)) return {};
    StageTimer timer(run.report(), "shadowmask");
    const uint64_t before = cached.integrator.raysTraced();
    baked.maskLayers = maskLayersOf(baked.scene);
    baked.shadowmasks.resize(std::size_t(cached.map.pageCount) * std::size_t(baked.maskLayers));
    for (int layer = 0; layer < baked.maskLayers; ++layer) {
        std::vector<vec4> mask = largeVector<vec4>(cached.map.texels.size());
        if (Status s = cached.shadowmask(layer, mask, run.progress); !s) return s;
        if (layer > 0) pages.wait(); // masks of two layers at one time, which bounds memory
        pages.run([&run, &cached, &valid, &seams, &pagesReport, layer, mask = std::move(mask)]() mutable {
            maskPagesStage(run, cached, valid, seams, layer, std::move(mask), pagesReport);
        });
    }
    timer.finish(cached.integrator.raysTraced() - before);
    if (run.progress.cancelled()) return cancelledError();
    return {};
}

} // namespace halflight
