#pragma once
// S35. Mixed lights whose masks have a colour.

#include "halflight/bake/integrator.h"

#include <span>
#include <string>
#include <vector>

namespace halflight {

struct ColoredMasks {
    bool any = false;                  ///< some light has a coloured mask; its channels and others' may be new ones
    std::vector<std::string> leftGray; ///< lights for which no layer had three channels free
};

/// Gives each light whose shadow has a colour the first three channels of a mask layer, of at most `mostLayers`; no
/// light loses its channel for it. Integrators made before know the channels of before. `shares`: by light of the
/// scene, as Integrator::coloredShadows() has them.
ColoredMasks colorMasks(Scene& scene, std::span<const float> shares, int mostLayers);

} // namespace halflight
