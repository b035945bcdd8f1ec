// Reflection probes: radiance around a point, prefiltered by roughness, as a glossy surface elsewhere in its room sees
// it. The split sum of Karis 2013, "Real Shading in Unreal Engine 4": this file gives its first factor,
// environmentSpecular() in brdf.h the second.
//
// A probe is a tile of a picture: octahedral maps of the sphere (Cigolle et al. 2014, "A Survey of Efficient
// Representations for Independent Unit Vectors"), one per roughness level. Each map has a border of one texel, which
// repeats what lies beyond the octahedron's edge, so that bilinear filtering has no seam.
#ifndef HALFLIGHT_SHADING_REFLECTION_H
#define HALFLIGHT_SHADING_REFLECTION_H

#include "language.h"
#include "sh.h"

HL_NAMESPACE_BEGIN

// A probe with less than this share of the blend is left out.
HL_CONST float kLeastReflectionShare = 0.02f;

// Unit direction to the unit square, +Y in its middle.
HL_FN vec2 octahedronFromDirection(vec3 d)
{
    vec2 p = vec2(d.x, d.z) * (1.0f / (abs(d.x) + abs(d.y) + abs(d.z)));
    if (d.y < 0.0f)
        p = vec2((1.0f - abs(p.y)) * (p.x >= 0.0f ? 1.0f : -1.0f), (1.0f - abs(p.x)) * (p.y >= 0.0f ? 1.0f : -1.0f));
    return p * 0.5f + 0.5f;
}
HL_FN vec3 directionFromOctahedron(vec2 uv)
{
    vec2 p = uv * 2.0f - 1.0f;
    vec3 d = vec3(p.x, 1.0f - abs(p.x) - abs(p.y), p.y);
    float fold = max(-d.y, 0.0f);
    d.x += d.x >= 0.0f ? -fold : fold;
    d.z += d.z >= 0.0f ? -fold : fold;
    return normalize(d);
}

// Width of a level's map in texels, its border included. `size`: that of level 0.
HL_FN int reflectionLevelSize(int size, int level)
{
    return size >> level;
}
// First texel of a level's map in the probe's tile, which is `size` wide and 3/2 `size` high: level 0 at the top, the
// others below it, side by side.
HL_FN vec2 reflectionLevelOffset(int size, int level)
{
    return level == 0 ? vec2(0.0f) : vec2(float(size - (size >> (level - 1))), float(size));
}
// Where a direction lies in the tile, in texels: texel i covers i … i + 1.
HL_FN vec2 reflectionTexel(int size, int level, vec3 direction)
{
    float inner = float(reflectionLevelSize(size, level) - 2);
    return reflectionLevelOffset(size, level) + 1.0f + octahedronFromDirection(direction) * inner;
}
// Level of a perceptual roughness: 0 is a mirror, the last one roughness 1; between two, interpolate.
HL_FN float reflectionLevel(float roughness, int levels)
{
    return saturate(roughness) * float(levels - 1);
}
HL_FN float reflectionRoughness(int level, int levels)
{
    return float(level) / float(levels - 1);
}

// Where a ray from inside of a box leaves it, as distance over the direction's length. A point outside counts as the
// nearest one inside.
HL_FN float distanceToBox(vec3 position, vec3 direction, vec3 boxMin, vec3 boxMax)
{
    vec3 inside = clamp(position, boxMin, boxMax);
    vec3 side = vec3(direction.x < 0.0f ? boxMin.x : boxMax.x, direction.y < 0.0f ? boxMin.y : boxMax.y,
                     direction.z < 0.0f ? boxMin.z : boxMax.z);
    vec3 way = abs(side - inside);
    vec3 speed = max(abs(direction), vec3(1.0e-6f));
    vec3 t = way / speed;
    return min(min(t.x, t.y), t.z);
}

// What a surface looks up: direction from the probe, and the roughness that blurs as much there.
struct ReflectionLookup {
    vec3 direction;
    float roughness;
};
// Parallax correction by the box that fits the room: Lagarde and Zanuttini 2012, "Local Image-based Lighting With
// Parallax-corrected Cubemap". The roughness is scaled by distance, as the same solid angle of a lobe is narrower or
// wider from the probe: Lagarde and de Rousiers 2014, "Moving Frostbite to Physically Based Rendering", section 4.9.5.
HL_FN ReflectionLookup lookUpReflection(vec3 position, vec3 direction, float roughness, vec3 probe, vec3 boxMin,
                                        vec3 boxMax)
{
    vec3 inside = clamp(position, boxMin, boxMax);
    float distanceFromSurface = distanceToBox(inside, direction, boxMin, boxMax);
    vec3 seen = inside + direction * distanceFromSurface - probe;
    float distanceFromProbe = max(length(seen), 1.0e-6f);
    ReflectionLookup result;
    result.direction = seen * (1.0f / distanceFromProbe);
    float scaled = clamp(distanceFromSurface / distanceFromProbe * roughness, 0.0f, roughness);
    result.roughness = mix(scaled, roughness, roughness);
    return result;
}

// 1 inside the box where a probe counts, 0 from `fadeMeters` outside of it on.
HL_FN float reflectionCoverage(vec3 position, vec3 influenceMin, vec3 influenceMax, float fadeMeters)
{
    vec3 outside = max(max(influenceMin - position, position - influenceMax), vec3(0.0f));
    return saturate(1.0f - length(outside) / fadeMeters);
}
// Weight of a probe among those that cover a point, not normalized: the nearest one dominates (Shepard 1968, "A
// Two-dimensional Interpolation Function for Irregularly-spaced Data", with the power 4).
HL_FN float reflectionWeight(float coverage, vec3 position, vec3 probe)
{
    vec3 way = position - probe;
    return square(coverage) / square(max(dot(way, way), 1.0e-4f));
}
// Weights of small shares fall to 0 steadily. `sum`: of all weights.
HL_FN float keptReflectionWeight(float weight, float sum)
{
    return max(weight - kLeastReflectionShare * sum, 0.0f);
}

// CIE luminance of a linear Rec. 709 colour (ITU-R BT.709, section 3).
HL_FN float luminanceOf(vec3 color)
{
    return dot(color, vec3(0.2126f, 0.7152f, 0.0722f));
}

// Luminance of the irradiance at the probe, on a normal. `c`: SH coefficients of the radiance's luminance, in the order
// of shBasis(); the last is separate.
HL_FN float reflectionIrradiance(vec4 c0123, vec4 c4567, float c8, vec3 n)
{
    float e = 0.0f;
    for (int i = 0; i < 4; ++i) e += c0123[i] * shIrradianceWeight(i, n) + c4567[i] * shIrradianceWeight(4 + i, n);
    return max(e + c8 * shIrradianceWeight(8, n), 0.0f);
}

// Radiance that the specular lobe meets, from what the probes hold. Normalization: where the surface gets less light
// than the probe did on the same normal, something local is in the way, and its reflections are darker (Lazarov 2013,
// "Getting More Physical in Call of Duty: Black Ops II"). That holds for the mean over the hemisphere, so a lobe takes
// part in it by its roughness: a mirror shows what its one ray meets, however dark its place. Where the surface gets
// more, the probe's picture stays as it is. The light that the probe does not have comes from a direction that is not
// known (the direct light of baked lights, mostly): a rough lobe meets its mean, and a narrow one misses it.
//   fromProbes     prefiltered radiance
//   probeIrradiance, localIrradiance   luminance of the irradiance on the normal, at the probe and on the surface
//   lobeIrradiance irradiance on a surface that faces the lobe, as far as known
HL_FN vec3 normalizedReflection(vec3 fromProbes, float probeIrradiance, float localIrradiance, vec3 lobeIrradiance,
                                float roughness)
{
    float least = 1.0e-12f;
    float scale = mix(1.0f, min(localIrradiance / max(probeIrradiance, least), 1.0f), roughness);
    float unknown = max(1.0f - probeIrradiance / max(localIrradiance, least), 0.0f);
    return fromProbes * scale + lobeIrradiance * (unknown * roughness / kShadingPi);
}

HL_NAMESPACE_END

#endif
