#pragma once

#include "halflight/scene/scene.h"

#include <span>

namespace halflight::charts {

/// Gives every corner of a part its lightmap coordinates (3 per triangle). A vertex whose corners need several is
/// copied in all its arrays: the first keeps its index, copies are appended, and sourceVertex says whose copies they
/// are.
void assignLightmapUv(MeshPart& part, std::span<const vec2> cornerUv);

/// The first n >= 1 whose TEXCOORD_n the part's material does not use.
int freeTexCoord(const Scene& scene, const MeshPart& part);

} // namespace halflight::charts
