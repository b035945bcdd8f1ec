#pragma once
// Which objects share the stored triangles of their mesh (BakeGeometry::Instance).

#include "bake/geometry/flatten.h"
#include "halflight/bake/bake_geometry.h"

#include <optional>
#include <vector>

namespace halflight {

enum class GeometryFilter;

/// By object: its instance, or nothing where its triangles are stored in world space. Meshes of few triangles and
/// meshes of few objects are not shared: rays are faster in one tree than in many that overlap. Objects that their
/// transform flattens are not shared either, because rays have no exact counterpart in the mesh.
std::vector<std::optional<BakeGeometry::Instance>> shareMeshes(const Scene& scene, int pageSize, GeometryFilter filter);

/// The middle of a mesh's bounds, to which stored vertices of shared meshes are relative.
vec3 middleOf(const Mesh& mesh);

/// World from normal up to scale; normals of mirrored triangles are turned to their front.
mat3 worldFromNormal(const mat3& linear);

} // namespace halflight
