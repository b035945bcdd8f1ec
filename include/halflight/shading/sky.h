// The gradient sky.
#ifndef HALFLIGHT_SHADING_SKY_H
#define HALFLIGHT_SHADING_SKY_H

#include "language.h"

HL_NAMESPACE_BEGIN

// Radiance (cd/m2) from unit direction d: linear in d.y from horizon to zenith above and from horizon to ground below.
HL_FN vec3 skyRadiance(vec3 zenith, vec3 horizon, vec3 ground, vec3 d)
{
    return d.y >= 0.0f ? mix(horizon, zenith, d.y) : mix(horizon, ground, -d.y);
}

HL_NAMESPACE_END

#endif
