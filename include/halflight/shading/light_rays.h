// Shadow rays of masks and of baked direct light: where lights reach, and what rays weigh.
#ifndef HALFLIGHT_SHADING_LIGHT_RAYS_H
#define HALFLIGHT_SHADING_LIGHT_RAYS_H

#include "light_source.h"

HL_NAMESPACE_BEGIN

// Whether a point is within range, reach and cone, and in front of an area light. A light with intensity 0 has a mask
// too, because it may be switched on at run time (spec S29).
HL_FN bool lightReaches(HL_IN(LightSource) light, vec3 point)
{
    if (isAreaLight(light.type)) {
        vec3 away = point - light.position;
        float far = length(away);
        return dot(away, light.axis) > 0.0f && (light.range <= 0.0f || far < light.range) &&
               (light.reach <= 0.0f || far <= light.reach);
    }
    LightSample one =
        sampleLight(light.type, vec3(1.0f), light.position, light.axis, light.range, light.spotConstants, point);
    return one.illuminance.x > 0.0f && (light.reach <= 0.0f || one.distance <= light.reach);
}

// Weight of a shadow ray among those of a mask: the share that it has in an area light's irradiance. Rays from below
// the horizon count little beside others, and all where there are no others, as on points that face away from a light
// without size: these are in shadow. 0: no ray.
HL_FN float maskRayWeight(HL_IN(LightSource) light, vec3 position, vec3 normal, vec2 disc)
{
    if (!isAreaLight(light.type)) return 1.0f;
    LightRay ray = sampleLightRay(light, position, disc);
    return ray.solidAngle * max(dot(normal, ray.direction), 1.0e-4f);
}

// Weight of a shadow ray among those of direct light: the irradiance that it stands for. 0: no ray.
HL_FN float irradianceRayWeight(HL_IN(LightSource) light, vec3 position, vec3 normal, vec2 disc)
{
    vec3 irradiance = sampledIrradiance(light, position, normal, disc, 1.0f, 1.0f);
    return min(luminanceOf(irradiance), 1.0e30f); // sums of weights must be finite
}

HL_NAMESPACE_END

#endif
