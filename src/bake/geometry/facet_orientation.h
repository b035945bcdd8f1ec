#pragma once
// Which side of open double-sided surfaces is outside.

#include "halflight/bake/integrator.h"

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace halflight {

/// Splits triangles into patches, connected across edges where the winding is consistent and the angle between the
/// normals below 50 degrees.
std::vector<std::vector<uint32_t>> facetPatches(const BakeGeometry& geometry, std::span<const uint32_t> triangles);

/// Flips double-sided patches whose front faces a narrow, closed, empty cavity (the inside of a rail, say) and whose
/// back faces open space. Returns an integrator for the repaired geometry. `tree`: one for the same surfaces, if there
/// is one already; else the geometry gets one for the test.
Result<std::unique_ptr<Integrator>> repairOrientation(const IntegratorFactory& factory, const Scene& scene,
                                                      BakeGeometry& geometry, const IntegrationSettings& settings,
                                                      const Integrator* tree = nullptr);

} // namespace halflight
