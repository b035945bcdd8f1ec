// The law of mixing (docs/conventions.md): the one place where baked and realtime shadow meet. Every renderer path and
// the tests call these functions.
//
// Symbols: R realtime attenuation from the shadow map (1 lit … 0 shadowed), B baked attenuation (the mask's or probe's
// channel of the light), t fade (0 near … 1 from the shadow distance on), k shadow strength (0…1).
#ifndef HALFLIGHT_SHADING_LAW_H
#define HALFLIGHT_SHADING_LAW_H

#include "language.h"

HL_NAMESPACE_BEGIN

// Run-time lighting modes. One shadowmask bake serves kModeShadowmask and kModeDistanceShadowmask.
HL_CONST int kModeRealtime = 0;
HL_CONST int kModeBakedIndirect = 1;
HL_CONST int kModeShadowmask = 2;
HL_CONST int kModeDistanceShadowmask = 3;
HL_CONST int kModeSubtractive = 4;

// S1. Constants of the fade for shadow distance s and fade range r > 0 (metres): t = saturate(c * x + y) is
// saturate((c - s) / r + 1), so t is 0 up to c = s - r and 1 from c = s on.
HL_FN vec2 fadeConstants(float shadowDistance, float fadeRange)
{
    return vec2(1.0f / fadeRange, 1.0f - shadowDistance / fadeRange);
}

// S1. t for a fragment c metres from the camera.
HL_FN float shadowFade(float cameraDistance, vec2 constants)
{
    return saturate(cameraDistance * constants.x + constants.y);
}

// S1. Whether a fragment looks into a light's shadow map at all. Where not, R counts for nothing in mixShadows().
HL_FN bool readsShadowMap(bool hasRealtime, float fade)
{
    return hasRealtime && fade < 1.0f;
}

// F: realtime attenuation faded out towards "lit".
HL_FN float fadeRealtimeShadow(float realtime, float fade)
{
    return mix(realtime, 1.0f, fade);
}

// S20. Strength, applied once, after mixing.
HL_FN float applyShadowStrength(float attenuation, float strength)
{
    return mix(1.0f, attenuation, strength);
}

// True when the mode reads baked attenuation of lights that have a channel.
HL_FN bool modeUsesBakedShadows(int mode)
{
    return mode == kModeShadowmask || mode == kModeDistanceShadowmask || mode == kModeSubtractive;
}

// B of a light at a point. Beyond the reach that the light had at its bake its channel says nothing of it, and may hold
// another light's shadows: there B is 1. distanceMeters and cosAngle are the point's distance and the cosine of its
// angle to the axis, as seen from where the light was baked; reachMeters 0 = unlimited; cosCone below -1 = no cone.
HL_FN float bakedWithinReach(float baked, float distanceMeters, float reachMeters, float cosAngle, float cosCone)
{
    bool within = (reachMeters <= 0.0f || distanceMeters <= reachMeters) && cosAngle >= cosCone;
    return within ? baked : 1.0f;
}

// The law, without strength. hasBaked: the light has a channel (in subtractive mode: the receiver is dynamic and the
// light is the main light). hasRealtime: the light has a shadow map this frame; realtime is read only if so.
HL_FN float mixShadowsFullStrength(int mode, bool hasBaked, float baked, bool hasRealtime, float realtime, float fade)
{
    float faded = hasRealtime ? fadeRealtimeShadow(realtime, fade) : 1.0f;
    if (!hasBaked || !modeUsesBakedShadows(mode)) return faded;
    // S4, S19: baked shadows never vanish because realtime ones do.
    if (!hasRealtime) return baked;
    if (mode == kModeDistanceShadowmask) return mix(realtime, baked, fade);
    return min(faded, baked);
}

// S7, S12, S13, S19, S20, S25: what a light's radiance is multiplied by.
HL_FN float mixShadows(int mode, bool hasBaked, float baked, bool hasRealtime, float realtime, float fade,
                       float strength)
{
    return applyShadowStrength(mixShadowsFullStrength(mode, hasBaked, baked, hasRealtime, realtime, fade), strength);
}

// S35. The law is one for each colour channel: baked is B by colour, of a mask that has one.
HL_FN vec3 mixShadowsByColor(int mode, bool hasBaked, vec3 baked, bool hasRealtime, float realtime, float fade,
                             float strength)
{
    return vec3(mixShadows(mode, hasBaked, baked.x, hasRealtime, realtime, fade, strength),
                mixShadows(mode, hasBaked, baked.y, hasRealtime, realtime, fade, strength),
                mixShadows(mode, hasBaked, baked.z, hasRealtime, realtime, fade, strength));
}

// S21…S24. Irradiance of a static receiver in subtractive mode: lightmap G (which holds the main light's direct light
// already) darkened where dynamic objects shadow the main light. mainIrradiance is the main light's unshadowed
// irradiance on the surface, L * saturate(N.l). baked is B, the main light's own mask: only light that arrives is taken
// away. Without a mask B is 1, and the guess is L * saturate(N.l) * (1 - F). faded is F; neither B nor F has strength.
HL_FN vec3 subtractiveIrradiance(vec3 lightmap, vec3 mainIrradiance, float baked, float faded, vec3 shadowColor,
                                 float strength)
{
    vec3 guess = mainIrradiance * (baked - min(baked, faded));
    vec3 shadowed = max(lightmap - guess, shadowColor);
    return min(lightmap, mix(lightmap, shadowed, strength));
}

// S35. The same with B by colour.
HL_FN vec3 subtractiveIrradianceByColor(vec3 lightmap, vec3 mainIrradiance, vec3 baked, float faded, vec3 shadowColor,
                                        float strength)
{
    return vec3(subtractiveIrradiance(lightmap, mainIrradiance, baked.x, faded, shadowColor, strength).x,
                subtractiveIrradiance(lightmap, mainIrradiance, baked.y, faded, shadowColor, strength).y,
                subtractiveIrradiance(lightmap, mainIrradiance, baked.z, faded, shadowColor, strength).z);
}

// S12, S13, S22. Whether a static object is drawn into a light's shadow map; dynamic casters always are.
// hasBaked: the light has a mask channel or is fully baked for static receivers (subtractive's main light).
HL_FN bool staticCastersInShadowMap(int mode, bool hasBaked)
{
    return !(hasBaked && (mode == kModeShadowmask || mode == kModeSubtractive));
}

HL_NAMESPACE_END

#endif
