// glTF's metallic-roughness BRDF (glTF 2.0 specification, appendix B).
#ifndef HALFLIGHT_SHADING_BRDF_H
#define HALFLIGHT_SHADING_BRDF_H

#include "language.h"

HL_NAMESPACE_BEGIN

// The one place where irradiance becomes the radiance a diffuse surface reflects: divide by pi.
HL_FN vec3 diffuseRadiance(vec3 diffuseAlbedo, vec3 irradiance)
{
    return diffuseAlbedo * irradiance * (1.0f / kShadingPi);
}

// Diffuse albedo and specular reflectance at normal incidence of a metallic-roughness material.
HL_FN vec3 diffuseAlbedoOf(vec3 baseColor, float metallic)
{
    return baseColor * (1.0f - metallic);
}
// specular: KHR_materials_specular's factor for the dielectric part, 1 = as glTF has it, 0 = purely diffuse.
HL_FN vec3 specularF0Of(vec3 baseColor, float metallic, float specular)
{
    return mix(vec3(0.04f * specular), baseColor, metallic);
}
HL_FN float specularF90Of(float metallic, float specular)
{
    return mix(specular, 1.0f, metallic);
}

// Schlick 1994, "An Inexpensive BRDF Model for Physically-based Rendering".
HL_FN vec3 fresnelSchlick(vec3 f0, float f90, float cosine)
{
    float m = saturate(1.0f - cosine);
    float m2 = m * m;
    return f0 + (vec3(f90) - f0) * (m2 * m2 * m);
}

// GGX distribution: Walter et al. 2007, "Microfacet Models for Refraction through Rough Surfaces", eq. 33; alpha =
// roughness^2.
HL_FN float distributionGgx(float nDotH, float alpha)
{
    float a2 = alpha * alpha;
    float d = nDotH * nDotH * (a2 - 1.0f) + 1.0f;
    return a2 / (kShadingPi * d * d);
}

// Height-correlated Smith masking-shadowing divided by 4 (N.l)(N.v): Heitz 2014, "Understanding the Masking-Shadowing
// Function in Microfacet-Based BRDFs", eq. 99.
HL_FN float visibilitySmithGgx(float nDotL, float nDotV, float alpha)
{
    float a2 = alpha * alpha;
    float v = nDotL * sqrt(nDotV * nDotV * (1.0f - a2) + a2);
    float l = nDotV * sqrt(nDotL * nDotL * (1.0f - a2) + a2);
    return 0.5f / max(v + l, 1.0e-6f);
}

// The lobe of reflectLight() without its Fresnel factor, per steradian; h is the unit vector between l and v.
HL_FN float ggxLobe(vec3 n, vec3 v, vec3 l, vec3 h, float alpha)
{
    float nDotV = max(abs(dot(n, v)), 1.0e-4f);
    return distributionGgx(saturate(dot(n, h)), alpha) * visibilitySmithGgx(saturate(dot(n, l)), nDotV, alpha);
}

// Radiance that the specular lobe reflects to v from light of the given illuminance arriving from l, cosine included.
HL_FN vec3 reflectSpecular(vec3 f0, float f90, float alpha, vec3 n, vec3 v, vec3 l, vec3 illuminance)
{
    float nDotL = saturate(dot(n, l));
    if (nDotL <= 0.0f) return vec3(0.0f);
    vec3 h = normalize(l + v);
    return fresnelSchlick(f0, f90, saturate(dot(v, h))) * ggxLobe(n, v, l, h, alpha) * illuminance * nDotL;
}

// Radiance reflected to v from light of the given illuminance arriving from l, cosine included.
// roughness is perceptual; below 0.045 it is raised so that highlights of punctual lights stay finite.
HL_FN vec3 reflectLight(vec3 baseColor, float metallic, float roughness, float specularFactor, vec3 n, vec3 v, vec3 l,
                        vec3 illuminance)
{
    float nDotL = saturate(dot(n, l));
    if (nDotL <= 0.0f) return vec3(0.0f);
    vec3 h = normalize(l + v);
    float alpha = square(max(roughness, 0.045f));
    vec3 f = fresnelSchlick(specularF0Of(baseColor, metallic, specularFactor), specularF90Of(metallic, specularFactor),
                            saturate(dot(v, h)));
    vec3 specular = f * ggxLobe(n, v, l, h, alpha);
    vec3 diffuse = (vec3(1.0f) - f) * diffuseAlbedoOf(baseColor, metallic) * (1.0f / kShadingPi);
    return (diffuse + specular) * illuminance * nDotL;
}

// Fraction of uniform surrounding light that the specular lobe of reflectLight() sends to the view: a fit to its
// integral (tests/shading integrates it) with a root mean square error of 2 %, for dielectrics as for metals. `lobe` is
// the integral for a reflectance of 1, `grazing` that of Schlick's (1 - v.h)^5.
HL_FN vec3 environmentSpecular(vec3 f0, float f90, float roughness, float nDotV)
{
    float r = roughness;
    float n = nDotV;
    float lobe = 1.0f + r * r *
                            (-2.204f + n * (5.198f - 2.029f * n) + r * (4.857f + n * (-16.357f + 7.975f * n)) +
                             r * r * (-2.814f + n * (10.142f - 5.450f * n)));
    float a = r * r;
    float fade = (0.452f + n * (6.304f - 22.126f * n) + 14.154f * a) / max(n + a * (1.223f + 1.952f * a), 1.0e-6f);
    float grazing = square(square(1.0f - n)) * (1.0f - n) * exp2(-a * fade);
    return f0 * (lobe - grazing) + vec3(f90 * grazing);
}

// What of uniform surrounding light the diffuse part of reflectLight() reflects to the view, over its albedo: the mean
// of 1 - F(v.h) over cosine-distributed light. The fit of (1 - v.h)^5 is off by 0.002 at most.
HL_FN vec3 diffuseShare(vec3 f0, float f90, float nDotV)
{
    return vec3(1.0f) - f0 - (vec3(f90) - f0) * (0.028f * pow(1.0f - nDotV, 2.4f));
}

// The mean of diffuseShare() over cosine-distributed views: what the diffuse part of reflectLight() reflects to all
// sides of light from all around, over its albedo.
HL_FN vec3 averageDiffuseShare(vec3 f0, float f90)
{
    return vec3(1.0f) - f0 - (vec3(f90) - f0) * 0.00374f;
}

// Fraction of light from all around that the specular lobe of reflectLight() sends to all sides (hemispherical
// reflectance), by fits to its integral, which are off by 0.006 at most. Rough ones lose light: the lobe leaves out
// what meets several microfacets.
HL_FN vec3 averageSpecular(vec3 f0, float f90, float roughness)
{
    float r2 = roughness * roughness;
    float all = 1.0f - r2 * roughness * (1.084f - 0.493f * r2);
    float grazing = 0.0476f * exp2(r2 * (1.712f * r2 - 5.82f));
    return f0 * (all - grazing) + vec3(f90 * grazing);
}

// Albedo of a surface for light that is carried on as if all surfaces were diffuse: metals reflect as much as their
// lobe does, to all sides. Gloss on a dielectric gives about what it takes from the diffuse light below, and is left
// out.
HL_FN vec3 transportAlbedo(vec3 baseColor, float metallic, float roughness)
{
    return diffuseAlbedoOf(baseColor, metallic) + metallic * averageSpecular(baseColor, 1.0f, roughness);
}

HL_NAMESPACE_END

#endif
