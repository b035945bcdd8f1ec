#pragma once
// The built-in denoiser. denoise.cpp says what it does.

#include "bake/seams/seams.h"
#include "bake/seams/surface_grid.h"

#include "halflight/bake/integrator.h"
#include "halflight/shading/denoise.h"

#include <algorithm>
#include <cstdint>
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
    std::vector<vec3> moments;      ///< first moments of all light, lux; empty where they are not wanted

    /// Of all light of a texel.
    [[nodiscard]] vec3 irradiance(std::size_t texel) const
    {
        return gathered[texel].irradiance + (direct.empty() ? vec3(0.0f) : direct[texel].irradiance);
    }
    /// A texel's light as an estimate states it.
    void set(std::size_t texel, const IrradianceEstimate& e)
    {
        gathered[texel] = shading::gatheredLight(e.irradiance, e.varianceOfMean, e.direct, e.varianceOfDirect);
        if (!direct.empty()) direct[texel] = shading::directLight(e.direct, e.varianceOfDirect);
        if (!moments.empty()) moments[texel] = e.moment;
    }
};

/// The processor's denoiser.
Signals denoisedSignals(const DenoiserInput& input);

/// What texels of a map have in common for all of their light.
struct DenoiserTexels {
    const BakeGeometry& geometry;
    const TexelMap& map;
    const SurfaceGrid& grid;
    std::span<const uint8_t> valid;   ///< by texel: 1 = outside geometry
    std::span<const uint8_t> samples; ///< by texel: samples(), of all light
    static uint8_t samplesOf(const IrradianceEstimate& estimate) { return uint8_t(std::min(estimate.samples, 255u)); }
};
/// Denoises light of several components (spec S33), each by weights of its own, as if it were the only one: what
/// another one's edge would keep apart is not lost. Places, neighbours and taps are found once for all.
void denoiseComponents(const DenoiserTexels& texels, std::span<Signals> components);

/// Edge-avoiding à-trous filter on the surface: within charts, and across their `seams` (denoise.cpp). Position, normal
/// and variance guide it. `directions`: also filters first moments, for directional lightmaps.
void denoise(const BakeGeometry& geometry, const TexelMap& map, std::span<const SeamSample> seams,
             std::vector<IrradianceEstimate>& estimates, bool directions = true);
/// The same on a device. Unsupported: the map is not for it, and the processor denoised. DeviceFailed: nobody did.
Status denoise(const BakeGeometry& geometry, const TexelMap& map, std::span<const SeamSample> seams,
               std::vector<IrradianceEstimate>& estimates, bool directions, const DeviceDenoiser& device);

} // namespace halflight
