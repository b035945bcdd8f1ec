#pragma once
// What comes before the denoiser's filter.

#include "bake/denoise/denoise.h"

namespace halflight {

/// Covered for the most part, and all of its sample points are valid.
bool isWhole(const TexelMap& map, const Texel& texel);

/// The estimates' signals, with calibrated variances and without outliers.
Signals clampedSignals(const DenoiserInput& input);

} // namespace halflight
