#pragma once
// The stage of a bake that denoises the lightmap's light, on a device where there is one.

#include "bake/denoise/component_signals.h"
#include "bake/first_stages.h"
#include "bake/seams/seams.h"

#include <cstdint>
#include <span>
#include <vector>

namespace halflight {

/// Of bakes without light groups. Where the map is not for the device, the processor denoises, and the report has a
/// warning. Errors: DeviceFailed, Cancelled.
Status denoiseStage(const BakeRun& run, const CachedIntegrator& cached, std::span<const SeamSample> seams,
                    const DeviceDenoiser& device, std::vector<IrradianceEstimate>& estimates);

/// Of each component, by weights of its own, as a bake of its lights alone would be. `valid` and `samples`: those of
/// DenoiserTexels. `report`: the bake's own, or one of the background.
Status denoiseStage(const BakeRun& run, const CachedIntegrator& cached, std::span<const SeamSample> seams,
                    const DeviceDenoiser& device, std::span<const uint8_t> valid, std::span<const uint8_t> samples,
                    ComponentSignals& components, BakeReport& report);

} // namespace halflight
