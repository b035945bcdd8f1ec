// Light of a mesh that is not a light's direct light: lightmap, probes, sky.
#ifndef HALFLIGHT_INDIRECT_GLSL
#define HALFLIGHT_INDIRECT_GLSL

#include "mesh_surface.glsl"
#include "halflight/shading/indirect.h"
#include "reflections.glsl"
#include "sky.glsl"

bool usesLightmap(Surface s) { return s.lightmapped && frame.mode.x != kModeRealtime; }

// Radiance towards the camera. Lightmap and surroundings reflect diffusely and in the specular lobe. `lightmap` is the
// irradiance there, after subtraction, read only where usesLightmap(); the dynamic lightmap is added to it.
vec3 indirectLight(MeshSurface mesh, vec3 lightmap)
{
    Surface s = mesh.lit;
    bool realtime = frame.mode.x == kModeRealtime;
    vec3 irradiance;
    vec3 surroundings; // in the mirror, blurrier when rougher
    vec3 lobe = specularLookup(s.view, s.normal, s.roughness);
    if (usesLightmap(s)) {
        vec3 dynamic = dynamicIrradiance();
        irradiance = lightmap * lightmapScale(mesh, s.normal) + dynamic;
        surroundings = lightmap * lightmapSpecularScale(mesh, lobe) + dynamic;
    } else {
        irradiance = irradianceFrom(mesh.probes, s.normal);
        surroundings = irradianceFrom(mesh.probes, lobe);
    }
    surroundings *= 1.0 / kShadingPi;
    if (hasReflections()) {
        Reflections r = reflectionsAt(s.position, reflect(-s.view, s.normal), s.roughness, s.normal);
        float trust = usesLightmap(s) ? reflectionTrust(mesh) : 1.0;
        surroundings = reflectedSurroundings(r.radiance, r.expected, r.coverage, trust, surroundings,
                                             irradiance * (1.0 / kShadingPi), s.roughness);
    } else if (realtime) {
        surroundings = mix(skyTowards(reflect(-s.view, s.normal), skyPictureLevel(s.roughness, frame.skyPicture.z)),
                           surroundings, s.roughness);
    }

    float nDotV = clamp(abs(dot(s.normal, s.view)), 1.0e-4, 1.0);
    return reflectIndirect(s.baseColor, s.metallic, s.roughness, s.specular, nDotV, irradiance, surroundings) *
           mesh.occlusion;
}

#endif
