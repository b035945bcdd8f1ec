// Tone mappers: exposed linear sRGB, 0 or more, to display-referred linear sRGB, which may lie a little outside 0…1.
#ifndef HALFLIGHT_SHADING_TONE_MAPPING_H
#define HALFLIGHT_SHADING_TONE_MAPPING_H

#include "language.h"

HL_NAMESPACE_BEGIN

// Values of halflight::ToneMapping.
HL_CONST int kToneMapNeutral = 0;
HL_CONST int kToneMapAces = 1;
HL_CONST int kToneMapAgx = 2;
HL_CONST int kToneMapNone = 3;

// Khronos PBR Neutral (Khronos Group 2024, "Khronos PBR Neutral Tone Mapper specification"): colours below 0.8 keep hue
// and saturation, highlights roll off to white.
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

// ACES' reference rendering transform and sRGB output, as Hill fitted them (Pettineo and Hill 2016, "BakingLab",
// ACES.hlsl). The exposure is raised by 1 / 0.6, as in three.js, so that middle grey stays about where it is.
HL_FN vec3 toneMapAces(vec3 color)
{
    vec3 c = color / 0.6f;
    vec3 v = vec3(dot(vec3(0.59719f, 0.35458f, 0.04823f), c), dot(vec3(0.07600f, 0.90834f, 0.01566f), c),
                  dot(vec3(0.02840f, 0.13383f, 0.83777f), c)); // to AP1, less saturated
    v = (v * (v + 0.0245786f) - 0.000090537f) / (v * (0.983729f * v + 0.4329510f) + 0.238081f);
    return vec3(dot(vec3(1.60475f, -0.53108f, -0.07367f), v), dot(vec3(-0.10208f, 1.10813f, -0.00605f), v),
                dot(vec3(-0.00327f, -0.07276f, 1.07602f), v)); // to sRGB
}

// AgX's curve, 0…1 of a logarithmic scale to 0…1 (Wrensch 2023, "Minimal AgX Implementation").
HL_FN float agxContrast(float x)
{
    return (((((15.5f * x - 40.14f) * x + 31.96f) * x - 6.868f) * x + 0.4298f) * x + 0.1191f) * x - 0.00232f;
}

// AgX as Blender has it, in primaries of Rec. 2020 (Sobotka 2023; Filament 1.45, ToneMapper.cpp): highlights lose
// saturation early.
HL_FN vec3 toneMapAgx(vec3 color)
{
    float minEv = -12.47393f; // log2(0.18) - 10
    float maxEv = 4.026069f;  // log2(0.18) + 6.5
    vec3 wide = vec3(dot(vec3(0.6274f, 0.3293f, 0.0433f), color), dot(vec3(0.0691f, 0.9195f, 0.0113f), color),
                     dot(vec3(0.0164f, 0.0880f, 0.8956f), color)); // sRGB to Rec. 2020 (ITU-R BT.2087)
    vec3 inset = vec3(dot(vec3(0.856627153f, 0.095121241f, 0.048251606f), wide),
                      dot(vec3(0.137318973f, 0.761241991f, 0.101439036f), wide),
                      dot(vec3(0.111898213f, 0.076799419f, 0.811302368f), wide));
    vec3 x = clamp((log2(max(inset, vec3(1.0e-10f))) - minEv) / (maxEv - minEv), vec3(0.0f), vec3(1.0f));
    vec3 y = vec3(agxContrast(x.x), agxContrast(x.y), agxContrast(x.z));
    vec3 outset = vec3(dot(vec3(1.127100582f, -0.110606643f, -0.016493939f), y),
                       dot(vec3(-0.141329763f, 1.157823702f, -0.016493939f), y),
                       dot(vec3(-0.141329763f, -0.110606643f, 1.251936407f), y));
    vec3 linear = pow(max(outset, vec3(0.0f)), vec3(2.2f));
    return vec3(dot(vec3(1.6605f, -0.5876f, -0.0728f), linear), dot(vec3(-0.1246f, 1.1329f, -0.0083f), linear),
                dot(vec3(-0.0182f, -0.1006f, 1.1187f), linear)); // Rec. 2020 to sRGB
}

HL_FN vec3 toneMapped(vec3 color, int mapper)
{
    if (mapper == kToneMapAces) return toneMapAces(color);
    if (mapper == kToneMapAgx) return toneMapAgx(color);
    return mapper == kToneMapNeutral ? toneMapNeutral(color) : color;
}

HL_NAMESPACE_END

#endif
