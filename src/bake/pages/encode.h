#pragma once
// From values to the pictures of a file.

#include "halflight/bake/integrator.h"

#include <cstdint>
#include <vector>

namespace halflight {

/// Values of the lightmap, by texel.
struct TexelValues {
    std::vector<vec3> irradiance; ///< lux
    std::vector<vec3> direct;     ///< lux: IrradianceEstimate::direct
};
TexelValues splitEstimates(const std::vector<IrradianceEstimate>& estimates);
/// 1 for each texel that is not inside geometry.
std::vector<uint8_t> validTexels(const TexelMap& map);

/// Lux per unit of the encoded lightmap: the smallest power of two, 1 or more, for which no finite texel is clamped. A
/// power of two changes no mantissa.
float lightmapUnitFor(const std::vector<ImageRgb32f>& pages);
/// Encodes pages in lux as RGB9E5 in units of `unitLux`, clamped to the format's range.
std::vector<Image<uint32_t>> encodeLightmap(const std::vector<ImageRgb32f>& pages, float unitLux);
/// Encodes mean directions (shading/directional.h) from pages of irradiance and of its first moment, both in lux.
std::vector<ImageRgba8> encodeDirections(const std::vector<ImageRgb32f>& irradiance,
                                         const std::vector<ImageRgb32f>& moments);
/// Attenuation or distance, 0…1, in 8 bits.
std::vector<ImageRgba8> encodeShadowmask(const std::vector<ImageRgba32f>& pages);

} // namespace halflight
