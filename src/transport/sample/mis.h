#pragma once
// Multiple importance sampling of area samples against cosine-distributed directions.

#include "halflight/shading/gather.h"

namespace halflight {

using shading::kShortOfSurface;
using shading::misWeightOfRay;
using shading::nextEventContribution;
using shading::NextEventContribution;

} // namespace halflight
