// Where rays start.
#ifndef HALFLIGHT_SHADING_RAYS_H
#define HALFLIGHT_SHADING_RAYS_H

#include "language.h"

HL_NAMESPACE_BEGIN

// Offset of ray origins along the normal, in metres. It grows with the coordinates, so it exceeds their rounding error.
// `sceneScale`: diagonal of the scene's bounds.
HL_FN float rayEpsilon(vec3 position, float sceneScale)
{
    float magnitude = max(max(abs(position.x), abs(position.y)), abs(position.z));
    return max(8.0e-7f * magnitude, 2.0e-6f * sceneScale);
}

HL_NAMESPACE_END

#endif
