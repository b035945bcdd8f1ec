// Importance sampling of glTF's BRDF (reflectLight() in brdf.h), for path tracers. Vectors are unit and in one space; n
// is the shading normal, v points to the view, l to the light. A view below the surface counts as its mirror image
// above.
#ifndef HALFLIGHT_SHADING_BRDF_SAMPLING_H
#define HALFLIGHT_SHADING_BRDF_SAMPLING_H

#include "brdf.h"
#include "sampling.h"

HL_NAMESPACE_BEGIN

// The alpha that reflectLight() uses for a perceptual roughness.
HL_FN float ggxAlphaOf(float roughness)
{
    return square(max(roughness, 0.045f));
}

// Least perceptual roughness of lobes that carry light from surface to surface. Narrower ones would show small lamps as
// single bright samples (Kaplanyan and Dachsbacher 2013, "Path Space Regularization for Holistic and Robust Light
// Transport").
HL_CONST float kLeastLobeRoughness = 0.3f;

// A normal of the GGX distribution that is visible from v, both in a frame whose +Z is the surface's normal; v.z >= 0.
// Heitz 2018, "Sampling the GGX Distribution of Visible Normals"; the sampling of the hemisphere is that of Dupuy and
// Benyoub 2023, "Sampling Visible GGX Normals with Spherical Caps".
HL_FN vec3 sampleVisibleNormal(vec3 v, float alpha, vec2 u)
{
    vec3 stretched = normalize(vec3(alpha * v.x, alpha * v.y, v.z));
    float phi = 2.0f * kShadingPi * u.x;
    float z = 1.0f - u.y * (1.0f + stretched.z);
    float sine = sqrt(saturate(1.0f - z * z));
    vec3 h = vec3(sine * cos(phi), sine * sin(phi), z) + stretched;
    return normalize(vec3(alpha * h.x, alpha * h.y, max(h.z, 1.0e-6f)));
}

// Density of l per steradian, when l is v reflected about a visible normal h: D(h) G1(v) / (4 N.v) (Heitz 2018, eq.
// 17), with G1 = 2 N.v / (N.v + sqrt(alpha^2 + (1 - alpha^2) (N.v)^2)).
HL_FN float visibleNormalPdf(vec3 n, vec3 v, vec3 l, float alpha)
{
    float a2 = alpha * alpha;
    float nDotV = max(dot(n, v), 0.0f);
    float nDotH = saturate(dot(n, normalize(l + v)));
    if (nDotH <= 0.0f) return 0.0f;
    return 0.5f * distributionGgx(nDotH, alpha) / (nDotV + sqrt(a2 + (1.0f - a2) * nDotV * nDotV));
}

// Probability with which directions are sampled from the specular lobe: about its share of the reflected light.
HL_FN float specularSamplingShare(vec3 baseColor, float metallic, float roughness, float specularFactor, float nDotV)
{
    float f90 = specularF90Of(metallic, specularFactor);
    vec3 specular = environmentSpecular(specularF0Of(baseColor, metallic, specularFactor), f90, roughness, nDotV);
    vec3 diffuse = diffuseAlbedoOf(baseColor, metallic);
    float s = max(dot(specular, vec3(1.0f)), 0.0f);
    float d = dot(diffuse, vec3(1.0f));
    if (f90 <= 0.0f) return 0.0f;
    if (d <= 0.0f) return 1.0f;
    return clamp(s / (s + d), 0.1f, 0.9f); // the share is an estimate, so both lobes keep a probability
}

HL_FN vec3 viewAbove(vec3 n, vec3 v)
{
    float side = dot(n, v);
    return side < 0.0f ? v - 2.0f * side * n : v;
}

// A direction for light: of the specular lobe with probability specularShare, else cosine-distributed. Directions of
// the specular lobe may lie below the surface, where the BRDF is 0.
HL_FN vec3 sampleBrdf(vec3 n, vec3 v, float alpha, float specularShare, float uLobe, vec2 u)
{
    vec3 t;
    vec3 b;
    orthonormalBasis(n, t, b);
    if (uLobe >= specularShare) {
        vec3 d = sampleCosineHemisphere(u);
        return normalize(t * d.x + b * d.y + n * d.z);
    }
    v = viewAbove(n, v);
    vec3 h = sampleVisibleNormal(vec3(dot(v, t), dot(v, b), max(dot(v, n), 0.0f)), alpha, u);
    h = t * h.x + b * h.y + n * h.z;
    return normalize(h * (2.0f * dot(v, h)) - v);
}

// Density of sampleBrdf() per steradian.
HL_FN float brdfPdf(vec3 n, vec3 v, vec3 l, float alpha, float specularShare)
{
    float diffuse = max(dot(n, l), 0.0f) * (1.0f / kShadingPi);
    if (specularShare <= 0.0f) return diffuse;
    return mix(diffuse, visibleNormalPdf(n, viewAbove(n, v), l, alpha), specularShare);
}

HL_NAMESPACE_END

#endif
