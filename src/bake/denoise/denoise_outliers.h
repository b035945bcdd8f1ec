#pragma once
// What comes before the denoiser's filter.

#include "bake/denoise/denoise.h"

namespace halflight {

/// Covered for the most part, and all of its sample points are valid.
bool isWhole(const TexelMap& map, const Texel& texel);
/// Fewer than prove that light is real.
bool hasFewSamples(const DenoiserTexels& texels, std::size_t texel);

/// Calibrates the variances of signals and removes their outliers, of each component by itself.
void clampSignals(const DenoiserTexels& texels, std::span<Signals> components);

} // namespace halflight
