#pragma once
// Where texels lie, and when two of them lie on one surface.

#include "halflight/bake/integrator.h"

namespace halflight {

/// A texel with a smaller coverage is at the rim of its surface.
constexpr float kMostlyCovered = 0.6f;

/// Texels between an edge and places that lie within it, despite rounding.
constexpr float kInsetTexels = 4.0e-3f;

/// A texel in the world.
struct TexelPlace {
    vec3 position{0.0f};      ///< centroid of the largest fragment, metres
    vec3 normal{0.0f};        ///< shading normal, unit
    float texelMeters = 0.0f; ///< width of a texel
};
TexelPlace placeOf(const BakeGeometry& geometry, const TexelMap& map, const Texel& texel);

} // namespace halflight
