#pragma once
// Whether a part of a mesh bounds a volume.

#include "halflight/scene/scene.h"

namespace halflight {

/// Whether the part is closed and faces outward: as many of its triangles pass each edge one way as the other, and the
/// volume that they enclose is positive. Corners at one place are one, as vertices of sharp edges are several.
bool isClosed(const MeshPart& part);

} // namespace halflight
