#pragma once
// Direct light of lights that are fully baked.

#include "transport/shadows/shadow_pass.h"

namespace halflight {

/// Adds the direct light of all fully baked lights to the texels of a pass: unshadowed irradiance times the lit share
/// of the shadow rays.
Status addBakedLights(const ShadowPass& pass, uint32_t seed, const TexelLight& out);

} // namespace halflight
