#pragma once
// Geometry that a file leaves out.

#include "halflight/scene/scene.h"

namespace halflight {

/// Gives every triangle vertices of its own, with its plane's normal (glTF 2.0, section 3.7.2.1: "flat normals").
void makeFlatNormals(MeshPart& part);

/// Keeps the vertices listed in `kept` (old indices, repeats allowed) in that order, in every array of the part.
void selectVertices(MeshPart& part, const std::vector<uint32_t>& kept);

} // namespace halflight
