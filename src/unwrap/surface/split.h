#pragma once

#include "halflight/scene/scene.h"

#include <span>

namespace halflight::charts {

/// Gives every corner of a part its lightmap coordinates (3 per triangle). A vertex whose corners need several is
/// copied in all its arrays: the first keeps its index, copies are appended, and sourceVertex says whose copies they
/// are.
void assignLightmapUv(MeshPart& part, std::span<const vec2> cornerUv);

/// The n >= 1 of the TEXCOORD_n for lightmap coordinates: one for all parts, since a node names one for its mesh. The
/// reader's choice, or the first beyond it that no part's material uses.
int freeTexCoord(const Scene& scene, const Mesh& mesh);

} // namespace halflight::charts
