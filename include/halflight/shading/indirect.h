// Light without single directions, as a surface reflects it: lightmap, probes, sky.
#ifndef HALFLIGHT_SHADING_INDIRECT_H
#define HALFLIGHT_SHADING_INDIRECT_H

#include "brdf.h"

HL_NAMESPACE_BEGIN

// Direction in which the specular lobe looks up its surroundings: the mirror's when smooth, the normal when rough.
HL_FN vec3 specularLookup(vec3 view, vec3 normal, float roughness)
{
    return normalize(mix(reflect(-view, normal), normal, roughness * roughness));
}

// Radiance towards the view. irradiance: on the normal. surroundings: radiance that the specular lobe meets.
HL_FN vec3 reflectIndirect(vec3 baseColor, float metallic, float roughness, float specularFactor, float nDotV,
                           vec3 irradiance, vec3 surroundings)
{
    vec3 f0 = specularF0Of(baseColor, metallic, specularFactor);
    float f90 = specularF90Of(metallic, specularFactor);
    vec3 albedo = diffuseAlbedoOf(baseColor, metallic) * diffuseShare(f0, f90, nDotV);
    vec3 diffuse = diffuseRadiance(albedo, irradiance);
    vec3 specular = environmentSpecular(f0, f90, roughness, nDotV) * surroundings;
    return diffuse + specular;
}

HL_NAMESPACE_END

#endif
