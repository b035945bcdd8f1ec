// Directional lightmaps (S32): what normal maps and mirrors see of baked light. Beside its irradiance E on the baked
// normal n, a texel keeps the mean direction that light came from, d = (integral of luminance * cosine * direction) /
// (integral of luminance * cosine), which is shorter than 1 the more the light is spread.
//
// Light is taken apart into an even hemisphere of sky around n and one distant light: the ambient and highlight
// direction (AHD) encoding of Iwanicki and Sloan 2017, "Precomputed Lighting in Call of Duty: Infinite Warfare", here
// found from d alone. An even hemisphere has the mean direction 2/3 n, a distant light in direction w has w itself;
// their mixture, with the light giving the share x of E, has
//     d = (1 - x) * 2/3 n + x * w,   |w| = 1,
// so with v = d - 2/3 n: |v|^2 / x^2 + 4/3 (v.n) / x - 5/9 = 0, whose positive root is x = 0.9 (b + sqrt(b^2 + 20/9
// |v|^2)), b = 4/3 (v.n). The result is exact for any mixture of the two.
#ifndef HALFLIGHT_SHADING_DIRECTIONAL_H
#define HALFLIGHT_SHADING_DIRECTIONAL_H

#include "brdf.h"
#include "luminance.h"

HL_NAMESPACE_BEGIN

// The highlight stands at least this high over the surface (sine of its elevation, roughly): a texel's light that
// arrives at a grazing angle says little about what a surface that faces it would get, and noise would be all of it.
HL_CONST float kMinHighlightElevation = 0.2f;

// The distant light of a mean direction: xyz its direction, of length about 1, w its share of the irradiance.
HL_FN vec4 bakedHighlight(vec3 meanDirection, vec3 bakedNormal)
{
    vec3 v = meanDirection - (2.0f / 3.0f) * bakedNormal;
    float b = (4.0f / 3.0f) * dot(v, bakedNormal);
    float share = clamp(0.9f * (b + sqrt(b * b + (20.0f / 9.0f) * dot(v, v))), 0.0f, 1.0f);
    vec3 highlight = v / max(share, 1.0e-4f) + (2.0f / 3.0f) * bakedNormal;
    highlight += bakedNormal * max(kMinHighlightElevation - dot(highlight, bakedNormal), 0.0f);
    return vec4(highlight, share);
}

// Irradiance on a surface of unit normal `normal` over that on the baked one, `bakedNormal`: 1 where they are the same.
HL_FN float directionalIrradianceScale(vec3 meanDirection, vec3 bakedNormal, vec3 normal)
{
    vec4 highlight = bakedHighlight(meanDirection, bakedNormal);
    vec3 toLight = vec3(highlight.x, highlight.y, highlight.z);
    float ambient = 0.5f + 0.5f * dot(normal, bakedNormal);
    float light = max(dot(toLight, normal), 0.0f) / max(dot(toLight, bakedNormal), 1.0e-4f);
    return mix(ambient, light, highlight.w);
}

// Mean directions longer than this count as this long: in 8 bits they are off by about as much.
HL_CONST float kSharpestMeanDirection = 0.99f;

// Radiance that the specular lobe meets, times pi, over the irradiance on the baked normal: what environmentSpecular()
// is to be multiplied with. `lobe` is specularLookup(). The even hemisphere counts with what faces the lobe, the
// distant light with the highlight that it makes on a surface of this roughness. The highlight is as sharp as the mean
// direction is long: an even cone of light of half-angle t has |d| = (1 + cos t) / 2. Half vectors of one mirror
// direction fill a cone of t / 2, and GGX is as high as their density where alpha = t / 2, whose square is 1 - |d|.
HL_FN float directionalSpecularScale(vec3 meanDirection, vec3 bakedNormal, vec3 normal, vec3 view, vec3 lobe,
                                     float roughness)
{
    vec4 highlight = bakedHighlight(meanDirection, bakedNormal);
    vec3 toLight = normalize(vec3(highlight.x, highlight.y, highlight.z));
    float spread = 1.0f - min(length(meanDirection), kSharpestMeanDirection);
    float alpha = min(sqrt(square(square(roughness)) + spread), 1.0f);
    float nDotL = saturate(dot(normal, toLight));
    float nDotV = clamp(abs(dot(normal, view)), 1.0e-4f, 1.0f);
    vec3 h = normalize(toLight + view);
    float specular = distributionGgx(saturate(dot(normal, h)), alpha) * visibilitySmithGgx(nDotL, nDotV, alpha) * nDotL;
    vec3 mirrored = environmentSpecular(vec3(1.0f), 1.0f, roughness, nDotV);
    float light = kShadingPi * specular / (max(mirrored.x, 0.05f) * max(dot(toLight, bakedNormal), 1.0e-4f));
    return mix(0.5f + 0.5f * dot(lobe, bakedNormal), light, highlight.w);
}

// d as a texture's colour, and back.
HL_FN vec3 encodeMeanDirection(vec3 meanDirection)
{
    return clamp(meanDirection * 0.5f + 0.5f, vec3(0.0f), vec3(1.0f));
}
HL_FN vec3 decodeMeanDirection(vec3 encoded)
{
    return encoded * 2.0f - 1.0f;
}

// Light that is added up (S33), each with a direction of its own: the mean direction of all is the sum of luminance
// times direction over the luminance of the sum, as d is a mean over luminance.
HL_FN vec3 directionMoment(vec3 irradiance, vec3 encodedDirection)
{
    return luminanceOf(irradiance) * decodeMeanDirection(encodedDirection);
}
// `moment`: the sum of directionMoment() of what makes up `irradiance`. Without light, no direction.
HL_FN vec3 encodeMomentDirection(vec3 irradiance, vec3 moment)
{
    float all = luminanceOf(irradiance);
    return encodeMeanDirection(all > 0.0f ? moment / all : vec3(0.0f));
}

HL_NAMESPACE_END

#endif
