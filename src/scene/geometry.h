#pragma once
// Geometry that a file leaves out.

#include "halflight/scene/scene.h"

namespace halflight {

/// Gives every triangle vertices of its own, with its plane's normal (glTF 2.0, section 3.7.2.1: "flat normals").
void makeFlatNormals(MeshPart& part);

/// Tangents from the gradients of texture coordinates `uv` (one per vertex) after the linear map `uvFromTexCoord`,
/// weighted by the angle at the vertex. A vertex between triangles of opposite texture orientation is split in two.
void makeTangents(MeshPart& part, const std::vector<vec2>& uv, const mat2& uvFromTexCoord);

/// Keeps the vertices listed in `kept` (old indices, repeats allowed) in that order, in every array of the part.
void selectVertices(MeshPart& part, const std::vector<uint32_t>& kept);

} // namespace halflight
