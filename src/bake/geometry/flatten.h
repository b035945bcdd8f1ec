#pragma once
// The triangles of a scene, in the order and storage that a bake uses.

#include "halflight/bake/integrator.h"

#include <cstdint>
#include <span>
#include <vector>

namespace halflight {

/// Which objects become geometry.
enum class GeometryFilter { Static, All };
/// The triangles of the scene, with solids marked (findSolids()). Objects that share a large mesh share its stored
/// triangles (shareMeshes()). `pageSize`: of the lightmap, in texels.
BakeGeometry flattenGeometry(const Scene& scene, int pageSize, GeometryFilter filter);

/// Numbers of parts that have each stored triangle once: all but the second and later instances of a mesh.
std::vector<uint32_t> partsOnce(const BakeGeometry& geometry);

/// Gives the objects of triangles stored triangles of their own (BakeGeometry::storeInWorldSpace()).
void storeInWorldSpace(BakeGeometry& geometry, std::span<const uint32_t> triangles);

/// Reverses the winding of triangles, and vertex normals that would point to their back. Their objects no longer share
/// stored triangles.
void flipTriangles(BakeGeometry& geometry, std::span<const uint32_t> triangles);

} // namespace halflight
