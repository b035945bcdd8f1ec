// Radiosity patches: which one a hit lies on, and its light.
#ifndef HALFLIGHT_SHADING_PATCHES_H
#define HALFLIGHT_SHADING_PATCHES_H

#include "language.h"

HL_NAMESPACE_BEGIN

// Number of a patch in its triangle's rectangle of them, row by row. `at`: the hit's place, in patches from the corner.
HL_FN uint patchNumberAt(vec2 at, int width, int height)
{
    int x = clamp(int(at.x), 0, width - 1);
    int y = clamp(int(at.y), 0, height - 1);
    return uint(y) * uint(width) + uint(x);
}

// Number of the element at a place along one axis. A patch is 2^shift elements wide.
HL_FN uint elementNumberAlong(float x, int patches, int shift)
{
    int whole = clamp(int(x), 0, patches - 1);
    int width = 1 << shift;
    return uint(clamp(int((x - float(whole)) * float(width)), 0, width - 1));
}

// Radiance of a patch back along a ray of a unit direction. `tilt`: its first moment.
HL_FN vec3 patchRadianceAlong(vec3 radiance, vec3 tilt, vec3 rayDirection)
{
    return radiance * (1.0f - dot(tilt, rayDirection));
}

HL_NAMESPACE_END

#endif
