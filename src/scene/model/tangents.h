#pragma once
// Tangents that a file leaves out.

#include "halflight/scene/scene.h"

namespace halflight {

/// Tangents of MikkTSpace (glTF 2.0, section 3.7.2.1; Mikkelsen 2008, "Simulation of Wrinkled Surfaces Revisited") for
/// texture coordinates `uv` (one per vertex) after the linear map `uvFromTexCoord`. A vertex whose corners get
/// different tangents is split. w is glTF's: 1 where the picture is not mirrored, as its v points down.
void makeTangents(MeshPart& part, const std::vector<vec2>& uv, const mat2& uvFromTexCoord);

} // namespace halflight
