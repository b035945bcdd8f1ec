#pragma once
// Where texels lie, and when two of them lie on one surface.

#include "halflight/bake/integrator.h"
#include "halflight/shading/texel_points.h"

namespace halflight {

using shading::kInsetTexels;
using shading::kMostlyCovered;

/// A texel in the world.
struct TexelPlace {
    vec3 position{0.0f};      ///< centroid of the largest fragment, metres
    vec3 normal{0.0f};        ///< shading normal, unit
    float texelMeters = 0.0f; ///< width of a texel
};
TexelPlace placeOf(const BakeGeometry& geometry, const TexelMap& map, const Texel& texel);

} // namespace halflight
