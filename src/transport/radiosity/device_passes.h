#pragma once
// The radiosity passes over items whose rays a device traces.

#include "transport/radiosity/device_radiosity.h"
#include "transport/radiosity/form_factors.h"

#include "halflight/base/progress.h"

#include <atomic>

namespace halflight {

/// OccluderSearch for all items of a pass.
Status findOccludedOn(DeviceRadiosity& device, const PatchPass& pass, std::span<const uint32_t> items,
                      std::vector<PatchId>& found, const Progress& progress, std::atomic<uint64_t>& rays);

/// FormFactorSampler for all items of a pass: `out` has one entry for each kRangeItems of them. The processor traces
/// the rays that hit no patch again, with their paths.
Status gatherOn(DeviceRadiosity& device, const PatchPass& pass, std::span<const uint32_t> items,
                std::span<FormFactorRange> out, const Progress& progress, std::atomic<uint64_t>& rays);

} // namespace halflight
