// What a shadowmask texel says: attenuation, or, where the bake chose so for a channel, the distance to the shadow's
// edge, from which any resolution of picture gets a crisp edge (Green 2007, "Improved Alpha-Tested Magnification for
// Vector Textures and Special Effects"). The one place where masks are decoded; format.md describes the encoding.
#ifndef HALFLIGHT_SHADING_MASK_H
#define HALFLIGHT_SHADING_MASK_H

#include "language.h"

HL_NAMESPACE_BEGIN

// Attenuation from a filtered texel, 0…1. rangeTexels: distance in texels that the values 0 and 1 stand for, 0 for a
// channel that holds attenuation as it is. penumbraTexels: width of the light's penumbra on average. footprintTexels:
// width of a pixel on the page; the edge never gets narrower than that, so it stays antialiased.
HL_FN float decodeMask(float stored, float rangeTexels, float penumbraTexels, float footprintTexels)
{
    if (rangeTexels <= 0.0f) return stored;
    float distance = (2.0f * stored - 1.0f) * rangeTexels; // above 0 in the light
    return saturate(0.5f + distance / max(max(penumbraTexels, footprintTexels), 1.0e-3f));
}

// A signed distance in texels as a texel's value.
HL_FN float encodeMaskDistance(float distanceTexels, float rangeTexels)
{
    return saturate(0.5f + 0.5f * distanceTexels / rangeTexels);
}

HL_NAMESPACE_END

#endif
