// Colour encoding and exposure of displayed pictures.
#ifndef HALFLIGHT_SHADING_COLOR_H
#define HALFLIGHT_SHADING_COLOR_H

#include "language.h"

HL_NAMESPACE_BEGIN

// IEC 61966-2-1.
HL_FN float srgbFromLinear(float x)
{
    return x <= 0.0031308f ? 12.92f * x : 1.055f * pow(x, 1.0f / 2.4f) - 0.055f;
}
HL_FN vec3 srgbFromLinear(vec3 c)
{
    return vec3(srgbFromLinear(c.x), srgbFromLinear(c.y), srgbFromLinear(c.z));
}

HL_FN float linearFromSrgb(float x)
{
    return x <= 0.04045f ? x / 12.92f : pow((x + 0.055f) / 1.055f, 2.4f);
}
HL_FN vec3 linearFromSrgb(vec3 c)
{
    return vec3(linearFromSrgb(c.x), linearFromSrgb(c.y), linearFromSrgb(c.z));
}

// Exposure value to a factor: EV 0 multiplies radiance by 1, each step up halves it.
HL_FN float exposureFactor(float ev)
{
    return exp2(-ev);
}

HL_NAMESPACE_END

#endif
