#pragma once
// Guides from the rays of the radiosity stage.

#include "transport/guiding/guides.h"
#include "transport/radiosity/build.h"

namespace halflight {

/// Builds the guides of a map. A guide follows only from sources that its own component of the scene contains: a light
/// switched on in one room must not change the random numbers of another.
Guides buildGuides(const Radiosity& radiosity, const TexelMap& map, const RayTracer& tracer);

} // namespace halflight
