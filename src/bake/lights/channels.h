#pragma once
// How each light is baked, and in which channel its mask is.

#include "halflight/bake/integrator.h"

namespace halflight {

/// Decides how each light is baked and assigns mask channels (spec S5, S9, S10, S36); writes Light::baking. Channels
/// are those of at most `mostLayers` mask layers.
void assignShadowmaskChannels(Scene& scene, MixedLightingMode mode, int mostLayers = 1);

/// Of a bake without bounces no light is reflected.
void limitBounces(Scene& scene, const IntegrationSettings& settings);

} // namespace halflight
