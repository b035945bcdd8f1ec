#pragma once
// Closed surfaces, whose inside is never seen.

#include "halflight/bake/integrator.h"

#include <vector>

namespace halflight {

/// Fills BakeGeometry::solid and BakeGeometry::flipped. A solid is a closed, outward-facing surface of one object or of
/// several together. Its inside is never seen, even if its material is double-sided (many exporters write that for all
/// materials). Double-sided, inward-facing surfaces around empty space are flipped: they are seen from outside.
void findSolids(const Scene& scene, BakeGeometry& geometry);

/// Positions of local lights, cameras and dynamic objects: space that contains one is not empty.
std::vector<vec3> lightAndViewPoints(const Scene& scene);

} // namespace halflight
