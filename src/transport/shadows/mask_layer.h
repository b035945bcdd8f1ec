#pragma once
// Masks of the lights of a layer.

#include "transport/shadows/shadow_pass.h"

namespace halflight {

/// Integrator::shadowmask(): attenuation by channel, by texel of the pass. Masks of light, as subtractive's main light
/// has, trace more rays on edges than the pass says.
Status traceMaskLayer(const ShadowPass& pass, uint32_t seed, int layer, std::span<vec4> out);

} // namespace halflight
