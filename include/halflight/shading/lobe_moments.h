// What the specular lobes of a patch reflect, and to which side: sums over samples.
#ifndef HALFLIGHT_SHADING_LOBE_MOMENTS_H
#define HALFLIGHT_SHADING_LOBE_MOMENTS_H

#include "brdf_sampling.h"
#include "luminance.h"

HL_NAMESPACE_BEGIN

// "Even" is light with the same radiance from all around.
struct LobeSums {
    vec3 albedo;           // share of even light that the lobes reflect
    float evenLight;       // luminance of sampled reflections of even light
    float evenCosine;      // the same times the cosine of their directions
    vec3 exitance;         // lux: direct light that the lobes reflect
    float sampledExitance; // luminance of sampled reflections of direct light
    vec3 sampledMoment;    // the same times their directions
    vec3 normal;           // of the surface
};

// A surface with a lobe.
struct LobeSurface {
    vec3 f0;
    float f90;
    float roughness; // perceptual, at least kLeastLobeRoughness
    vec3 normal;
    vec3 geometricNormal;
};

struct LobeSample {
    vec3 share;
    vec3 direction;
};

// A direction to which a lobe reflects light, and the share that it reflects. The lobe is sampled from the light's
// side, where it is the same (reciprocity). Zero where the sample lies below the triangle or is not finite.
HL_FN LobeSample reflectOfLobe(LobeSurface s, vec3 toLight, vec2 u)
{
    LobeSample none;
    none.share = vec3(0.0f);
    none.direction = vec3(0.0f);
    float alpha = ggxAlphaOf(s.roughness);
    LobeSample result;
    result.direction = sampleBrdf(s.normal, toLight, alpha, 1.0f, 0.0f, u);
    if (!(dot(result.direction, s.geometricNormal) > 0.0f)) return none;
    float pdf = brdfPdf(s.normal, toLight, result.direction, alpha, 1.0f);
    result.share = reflectSpecular(s.f0, s.f90, alpha, s.normal, toLight, result.direction, vec3(1.0f / pdf));
    // A share that is not finite is not equal to itself when it is taken from itself.
    if (!(dot(result.share - result.share, vec3(1.0f)) == 0.0f)) return none;
    return result;
}

// A direction that even light comes from.
HL_FN vec3 evenDirection(vec3 normal, vec2 u)
{
    vec3 tangent;
    vec3 bitangent;
    orthonormalBasis(normal, tangent, bitangent);
    vec3 local = sampleCosineHemisphere(u);
    return local.x * tangent + local.y * bitangent + local.z * normal;
}

// The surface at a sample. Its reflection of even light, which comes from `toLight`.
HL_FN void addLobeSurface(HL_INOUT(LobeSums) sums, LobeSurface s, vec3 toLight, vec2 u)
{
    sums.normal += s.normal;
    sums.albedo += averageSpecular(s.f0, s.f90, s.roughness);
    LobeSample reflected = reflectOfLobe(s, toLight, u);
    sums.evenLight += luminanceOf(reflected.share);
    sums.evenCosine += luminanceOf(reflected.share) * dot(reflected.direction, s.normal);
}

// Light that arrives from one direction, in lux on the surface: by reciprocity the lobe reflects of it what it sends to
// that side of even light. Samples give the mean direction alone, since their shares are noisy.
HL_FN void addLobeLight(HL_INOUT(LobeSums) sums, LobeSurface s, vec3 toLight, vec3 irradiance, vec2 u)
{
    float cosine = clamp(dot(s.normal, toLight), 0.0f, 1.0f);
    vec3 share = environmentSpecular(s.f0, s.f90, s.roughness, cosine);
    sums.exitance += irradiance * max(share, vec3(0.0f));
    LobeSample reflected = reflectOfLobe(s, toLight, u);
    sums.sampledExitance += luminanceOf(irradiance * reflected.share);
    sums.sampledMoment += luminanceOf(irradiance * reflected.share) * reflected.direction;
}

HL_NAMESPACE_END

#endif
