#pragma once
// Masks as distances to the edge of a shadow.

#include "halflight/bake/integrator.h"

#include <array>
#include <vector>

namespace halflight {

/// Turns channels whose shadows have narrow penumbrae into distance fields (shading/mask.h); other channels stay
/// attenuation, and so do those before `first`. Returns the encoding of each channel. `mask` is of one mask layer.
std::array<MaskChannel, kLayerChannels> maskToDistances(const TexelMap& map, std::vector<vec4>& mask, int first = 0);

} // namespace halflight
