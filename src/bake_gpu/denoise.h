#pragma once
// The denoiser on a device.

#include "bake/denoise/denoise.h"
#include "bake_gpu/bake_device.h"

#include <span>

namespace halflight {

/// Of the clock, for benchmarks; of all components together.
struct DenoiseSeconds {
    double memory = 0.0; ///< to get the device's memory, and at first to compile shaders
    double upload = 0.0;
    double filter = 0.0;
    double download = 0.0;
};

/// A DeviceDenoiser: light as denoiseComponents() leaves it, but for rounding. It takes 8 bytes of the device's memory
/// for each place of a page, and 48 for each crossing of a seam. For each texel it takes 80, 32 more if some component
/// has direct light, and 24 more if some has first moments.
Status denoiseOnDevice(BakeDevice& device, const DenoiserTexels& texels, std::span<Signals> components,
                       DenoiseSeconds* seconds = nullptr);

} // namespace halflight
