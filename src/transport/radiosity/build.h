#pragma once
// The radiosity stage: patches, form factors, solution.

#include "transport/radiosity/solve.h"

#include "halflight/base/progress.h"
#include "halflight/base/result.h"

#include <atomic>

namespace halflight {

struct Radiosity {
    Patches patches; ///< without their layout, which the cache has
    RadiositySolution solution;
};

/// Tiles the map's surfaces by patches and computes their radiance after up to settings.bounces (at least 1) bounces.
Result<Radiosity> buildRadiosity(const RadiosityInput& input, const Progress& progress, std::atomic<uint64_t>& rays);

/// The passes of buildRadiosity() alone, whose parts input.store keeps.
Status buildRadiosityParts(const RadiosityInput& input, const Progress& progress, std::atomic<uint64_t>& rays);

} // namespace halflight
