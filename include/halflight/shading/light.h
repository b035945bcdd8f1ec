// Punctual lights of KHR_lights_punctual: attenuation by distance and cone. Area lights are in area_light.h.
#ifndef HALFLIGHT_SHADING_LIGHT_H
#define HALFLIGHT_SHADING_LIGHT_H

#include "language.h"

HL_NAMESPACE_BEGIN

HL_CONST int kLightDirectional = 0;
HL_CONST int kLightPoint = 1;
HL_CONST int kLightSpot = 2;
HL_CONST int kLightRectangle = 3; // area lights: see area_light.h
HL_CONST int kLightDisk = 4;

// Window that KHR_lights_punctual recommends ("Range Property"): max(min(1 - (d / range)^4, 1), 0), by the square of
// the distance in metres. rangeMeters 0 = unlimited.
HL_FN float rangeWindow(float squaredDistance, float rangeMeters)
{
    float ratio2 = squaredDistance / max(rangeMeters * rangeMeters, 1.0e-30f);
    return rangeMeters > 0.0f ? saturate(1.0f - ratio2 * ratio2) : 1.0f;
}

// Inverse square law with the range window, in 1/m^2. Distances below a millimetre count as one.
HL_FN float distanceAttenuation(float distanceMeters, float rangeMeters)
{
    float d2 = max(distanceMeters * distanceMeters, 1.0e-6f);
    return rangeWindow(d2, rangeMeters) / d2;
}

// Scale and offset that turn cos(angle to axis) into cone attenuation (KHR_lights_punctual, "Inner and Outer Cone
// Angles"), from the cosines of both angles.
HL_FN vec2 spotConstantsOfCosines(float cosInner, float cosOuter)
{
    float scale = 1.0f / max(0.001f, cosInner - cosOuter);
    return vec2(scale, -cosOuter * scale);
}
HL_FN vec2 spotConstants(float innerConeRadians, float outerConeRadians)
{
    return spotConstantsOfCosines(cos(innerConeRadians), cos(outerConeRadians));
}

HL_FN float spotAttenuation(float cosAngle, vec2 constants)
{
    float a = saturate(cosAngle * constants.x + constants.y);
    return a * a;
}

// What a surface point receives from a light when nothing is in the way.
struct LightSample {
    vec3 direction;   // unit, from the surface to the light
    float distance;   // metres; 1e30 for directional lights
    vec3 illuminance; // lux on a surface that faces the light; multiply by saturate(N.l)
};

// colorIntensity: colour times intensity (candela or lux). axis: unit vector along which the light shines.
HL_FN LightSample sampleLight(int type, vec3 colorIntensity, vec3 lightPosition, vec3 axis, float rangeMeters,
                              vec2 spotScaleOffset, vec3 surfacePosition)
{
    LightSample s;
    if (type == kLightDirectional) {
        s.direction = -axis;
        s.distance = 1.0e30f;
        s.illuminance = colorIntensity;
        return s;
    }
    vec3 toLight = lightPosition - surfacePosition;
    s.distance = max(length(toLight), 1.0e-6f);
    s.direction = toLight / s.distance;
    float attenuation = distanceAttenuation(s.distance, rangeMeters);
    if (type == kLightSpot) attenuation *= spotAttenuation(dot(-s.direction, axis), spotScaleOffset);
    s.illuminance = colorIntensity * attenuation;
    return s;
}

HL_NAMESPACE_END

#endif
