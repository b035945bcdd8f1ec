#pragma once
// The built-in denoiser. denoise.cpp says what it does.

#include "bake/seams/seams.h"
#include "bake/seams/surface_grid.h"

#include "halflight/bake/integrator.h"
#include "halflight/shading/denoise.h"

#include <span>
#include <vector>

namespace halflight {

using shading::NoisyLight;

/// The map that estimates are denoised on.
struct DenoiserInput {
    const BakeGeometry& geometry;
    const TexelMap& map;
    const SurfaceGrid& grid;
    std::span<const IrradianceEstimate> estimates; ///< by texel
    bool hasDirect = false;                        ///< some estimate has direct light of baked lights
    bool directions = false;                       ///< first moments are filtered too
};

/// What the denoiser filters, by texel.
struct Signals {
    std::vector<NoisyLight> gathered;
    std::vector<NoisyLight> direct; ///< empty where no light is fully baked
    std::vector<vec3> moments;      ///< first moments of all light, lux
};

/// The processor's denoiser.
Signals denoisedSignals(const DenoiserInput& input);

/// Edge-avoiding à-trous filter on the surface: within charts, and across their `seams` (denoise.cpp). Position, normal
/// and variance guide it. `directions`: also filters first moments, for directional lightmaps.
void denoise(const BakeGeometry& geometry, const TexelMap& map, std::span<const SeamSample> seams,
             std::vector<IrradianceEstimate>& estimates, bool directions = true);
/// The same on a device. Unsupported: the map is not for it, and the processor denoised. DeviceFailed: nobody did.
Status denoise(const BakeGeometry& geometry, const TexelMap& map, std::span<const SeamSample> seams,
               std::vector<IrradianceEstimate>& estimates, bool directions, const DeviceDenoiser& device);

} // namespace halflight
