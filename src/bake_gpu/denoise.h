#pragma once
// The denoiser on a device.

#include "bake/denoise/denoise.h"
#include "bake_gpu/bake_device.h"

namespace halflight {

/// Of the clock, for benchmarks.
struct DenoiseSeconds {
    double memory = 0.0; ///< to get the device's memory, and at first to compile shaders
    double upload = 0.0;
    double filter = 0.0;
    double download = 0.0;
};

/// Signals as denoisedSignals() gives them, but for rounding. It takes 164 bytes of the device's memory for each texel,
/// and 8 for each place of a page.
Result<Signals> denoisedOnDevice(BakeDevice& device, const DenoiserInput& input, DenoiseSeconds* seconds = nullptr);

} // namespace halflight
