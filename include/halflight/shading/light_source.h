// Lights of a scene as paths sample them: punctual lights with their size, and area lights.
#ifndef HALFLIGHT_SHADING_LIGHT_SOURCE_H
#define HALFLIGHT_SHADING_LIGHT_SOURCE_H

#include "area_sampling.h"
#include "luminance.h"

HL_NAMESPACE_BEGIN

struct LightSource {
    int type;
    vec3 colorIntensity; // cd/m2 of an area light
    vec3 position;
    vec3 axis;
    vec3 tangent; // with bitangent and axis an orthonormal basis
    vec3 bitangent;
    float range; // metres; 0 = unlimited
    float reach; // metres covered by the light's mask channel; 0 = unlimited
    vec2 spotConstants;
    vec3 halfWidth; // area lights: along their X and Y, metres
    vec3 halfHeight;
    float radius;           // metres; point and spot
    float tanAngularRadius; // directional
    uint castShadows;       // 1 or 0
    float shadowStrength;
    float indirectMultiplier;
};

// Ray from a receiver to a point of a light.
struct LightRay {
    vec3 direction;
    float distance;
    // Area lights: steradians that the point stands for, 1 / pdf; 0 = the sample misses the light.
    float solidAngle;
};

HL_FN LightRay lightRay(vec3 direction, float distance, float solidAngle)
{
    LightRay ray;
    ray.direction = direction;
    ray.distance = distance;
    ray.solidAngle = solidAngle;
    return ray;
}

// Ray from `origin` to a point of an area light, of a light's sphere or of the sun's disc; `disc` is in the unit disc.
HL_FN LightRay sampleLightRay(HL_IN(LightSource) light, vec3 origin, vec2 disc)
{
    if (light.type == kLightDirectional) {
        if (light.tanAngularRadius <= 0.0f) return lightRay(-light.axis, 1.0e30f, 0.0f);
        vec3 offset = light.tanAngularRadius * (disc.x * light.tangent + disc.y * light.bitangent);
        return lightRay(normalize(offset - light.axis), 1.0e30f, 0.0f);
    }
    vec3 toLight = light.position - origin;
    if (isAreaLight(light.type)) {
        AreaSample point = sampleAreaLight(light.type, toLight, light.halfWidth, light.halfHeight, squareOfDisc(disc));
        float distance = max(length(point.position), 1.0e-20f);
        return lightRay(point.position / distance, distance, point.solidAngle);
    }
    if (light.radius > 0.0f) {
        float middle = length(toLight);
        if (middle > 0.0f) {
            vec3 tangent;
            vec3 bitangent;
            orthonormalBasis(toLight / middle, tangent, bitangent);
            toLight += light.radius * (disc.x * tangent + disc.y * bitangent);
        }
    }
    float distance = max(length(toLight), 1.0e-20f);
    return lightRay(toLight / distance, distance, 0.0f);
}

// Illuminance and direction at an unoccluded point; not of area lights.
HL_FN LightSample lightAt(HL_IN(LightSource) light, vec3 point)
{
    return sampleLight(light.type, light.colorIntensity, light.position, light.axis, light.range, light.spotConstants,
                       point);
}

// Radiance of an area light as a point receives it: by the range's window.
HL_FN vec3 areaRadianceAt(HL_IN(LightSource) light, vec3 point)
{
    vec3 toCenter = light.position - point;
    return light.colorIntensity * rangeWindow(dot(toCenter, toCenter), light.range);
}

// Unoccluded irradiance by a light, or by the part of an area light that `ray` from the point stands for.
HL_FN vec3 irradianceByRay(HL_IN(LightSource) light, HL_IN(LightRay) ray, vec3 point, vec3 normal)
{
    if (isAreaLight(light.type))
        return areaRadianceAt(light, point) * (ray.solidAngle * max(dot(normal, ray.direction), 0.0f));
    LightSample from = lightAt(light, point);
    return from.illuminance * max(dot(normal, from.direction), 0.0f);
}

// The same, with a point of the disc, times a multiplier and over a probability.
HL_FN vec3 sampledIrradiance(HL_IN(LightSource) light, vec3 point, vec3 normal, vec2 disc, float multiplier,
                             float probability)
{
    if (isAreaLight(light.type))
        return irradianceByRay(light, sampleLightRay(light, point, disc), point, normal) * (multiplier / probability);
    LightSample from = lightAt(light, point);
    float cosine = dot(normal, from.direction);
    return cosine > 0.0f ? from.illuminance * (cosine * multiplier / probability) : vec3(0.0f);
}

// Share of a light that its shadow leaves, by colour.
HL_FN vec3 shadowOf(HL_IN(LightSource) light, vec3 transmittance)
{
    return vec3(mix(1.0f, transmittance.x, light.shadowStrength), mix(1.0f, transmittance.y, light.shadowStrength),
                mix(1.0f, transmittance.z, light.shadowStrength));
}

// One of any number of lights, chosen in proportion to the luminance of what they give (Shirley et al. 1996, "Monte
// Carlo Techniques for Direct Lighting Calculations", section 5). The choice is a weighted reservoir of size one (Chao
// 1982, "A General Purpose Unequal Probability Sampling Plan"): each light uses the random number and makes it new, so
// that they need no memory.
struct LightReservoir {
    uint chosen;       // number of the light; 0xffffffff: none yet
    vec3 contribution; // of the chosen light
    float weight;      // its luminance
    float total;       // of all lights
    float u;           // in 0...1
};

HL_FN LightReservoir lightReservoir(float u)
{
    LightReservoir reservoir;
    reservoir.chosen = 0xffffffffu;
    reservoir.contribution = vec3(0.0f);
    reservoir.weight = 0.0f;
    reservoir.total = 0.0f;
    reservoir.u = u;
    return reservoir;
}

// `contribution`: of light `number`, over the probability with which it is considered.
HL_FN void considerLight(HL_INOUT(LightReservoir) reservoir, uint number, vec3 contribution)
{
    float weight = luminanceOf(contribution);
    if (weight <= 0.0f) return;
    reservoir.total += weight;
    float take = weight / reservoir.total;
    if (reservoir.u < take) {
        reservoir.chosen = number;
        reservoir.weight = weight;
        reservoir.contribution = contribution;
        reservoir.u /= take;
    } else {
        reservoir.u = (reservoir.u - take) / (1.0f - take);
    }
}

// Probability with which one of several sets of lights is chosen, of which `total` is the reservoir's and `all` the sum
// of those of the `reaching` sets whose light reaches the place: half in proportion to their light, half evenly, so
// that a dim one has samples too.
HL_FN float probabilityOfSet(float total, float all, int reaching)
{
    return 0.5f * total / all + 0.5f / float(reaching);
}

// Of the chosen light, over the probability with which it was chosen.
HL_FN vec3 contributionOfChosen(HL_IN(LightReservoir) reservoir)
{
    return reservoir.contribution * (reservoir.total / reservoir.weight);
}

HL_NAMESPACE_END

#endif
