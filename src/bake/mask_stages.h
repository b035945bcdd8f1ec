#pragma once
// Masks: traced, and made into pages.

#include "bake/cache/cached_integrator.h"
#include "bake/first_stages.h"
#include "bake/report/bake_report.h"
#include "bake/seams/seams.h"

#include "halflight/base/parallel.h"

#include <span>
#include <vector>

namespace halflight {

/// A mask's pages: filled inside geometry, dilated, stitched, encoded. Channels from `firstDistance` on may become
/// distances, whose encoding goes to `channels`; kLayerChannels: none.
std::vector<ImageRgba8> maskPages(const CachedIntegrator& cached, const std::vector<uint8_t>& valid,
                                  const std::vector<SeamSample>& seams, std::vector<vec4> mask, int firstDistance,
                                  std::span<MaskChannel, kLayerChannels> channels);

/// Traces masks. Makes the pages of each layer in the background.
Status shadowmaskStage(const BakeRun& run, const CachedIntegrator& cached, const std::vector<uint8_t>& valid,
                       const std::vector<SeamSample>& seams, BakeReport& pagesReport, Background& pages);

} // namespace halflight
