// Luminance of colours.
#ifndef HALFLIGHT_SHADING_LUMINANCE_H
#define HALFLIGHT_SHADING_LUMINANCE_H

#include "language.h"

HL_NAMESPACE_BEGIN

// CIE luminance of a linear Rec. 709 colour (ITU-R BT.709, section 3).
HL_FN float luminanceOf(vec3 color)
{
    return dot(color, vec3(0.2126f, 0.7152f, 0.0722f));
}

// The share of a light that its shadow leaves for what has no colour, as masks: of coloured light that of its
// luminance.
HL_FN float grayOf(vec3 transmittance)
{
    bool gray = transmittance.x == transmittance.y && transmittance.x == transmittance.z;
    return gray ? transmittance.x : luminanceOf(transmittance);
}

HL_NAMESPACE_END

#endif
