#pragma once
// Direct light of lights that are fully baked.

#include "bake_cpu/shadows/shadow_pass.h"

namespace halflight {

/// Adds the direct light of all lights that the lightmap holds to the texels of a pass: what they would have without
/// shadows, times the share of rays that arrive. False when cancelled.
bool addBakedLights(const ShadowPass& pass, uint32_t seed, std::span<IrradianceEstimate> out);

} // namespace halflight
