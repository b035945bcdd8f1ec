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

/// What the denoiser filters of one component, by texel.
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

/// What texels of a map have in common for all of their light.
struct DenoiserTexels {
    const BakeGeometry& geometry;
    const TexelMap& map;
    const SurfaceGrid& grid;
    std::span<const uint8_t> valid;   ///< by texel: 1 = outside geometry
    std::span<const uint8_t> samples; ///< by texel: samplesOf(), of all light
    static uint8_t samplesOf(const IrradianceEstimate& estimate) { return uint8_t(std::min(estimate.samples, 255u)); }
};
/// Denoises light of components (spec S33) in its place, each by weights of its own, as if it were the only one: what
/// another one's edge would keep apart is not lost. Places, neighbours and taps are found once for all. Gathered light
/// of invalid texels becomes black. The other light of such texels stays.
void denoiseComponents(const DenoiserTexels& texels, std::span<Signals> components);
/// The same on a device; an empty one is the processor. Unsupported: the map is not for the device, and the processor
/// denoised. DeviceFailed: nobody did, and the light is as it was.
Status denoiseComponents(const DenoiserTexels& texels, std::span<Signals> components, const DeviceDenoiser& device);

/// Edge-avoiding à-trous filter on the surface: within charts, and across their `seams` (denoise.cpp). Position, normal
/// and variance guide it. `directions`: also filters first moments, for directional lightmaps.
void denoise(const BakeGeometry& geometry, const TexelMap& map, std::span<const SeamSample> seams,
             std::vector<IrradianceEstimate>& estimates, bool directions = true);
/// The same as denoiseComponents() does it with a device, of one component.
Status denoise(const BakeGeometry& geometry, const TexelMap& map, std::span<const SeamSample> seams,
               std::vector<IrradianceEstimate>& estimates, bool directions, const DeviceDenoiser& device);

} // namespace halflight
