// Colour encoding and tone mapping of displayed pictures.
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

// Khronos PBR Neutral tone mapper (Khronos Group 2024, "Khronos PBR Neutral Tone Mapper specification"): colours below
// 0.8 keep hue and saturation, highlights roll off to white.
HL_FN vec3 toneMapNeutral(vec3 color)
{
    float startCompression = 0.8f - 0.04f;
    float desaturation = 0.15f;
    float x = min(color.x, min(color.y, color.z));
    float offset = x < 0.08f ? x - 6.25f * x * x : 0.04f;
    color = color - vec3(offset);
    float peak = max(color.x, max(color.y, color.z));
    if (peak < startCompression) return color;
    float d = 1.0f - startCompression;
    float newPeak = 1.0f - d * d / (peak + d - startCompression);
    color = color * (newPeak / peak);
    float g = 1.0f - 1.0f / (desaturation * (peak - newPeak) + 1.0f);
    return mix(color, vec3(newPeak), g);
}

HL_NAMESPACE_END

#endif
