// Reflection probes: radiance around a point, prefiltered by roughness, as a glossy surface elsewhere in its room sees
// it. The split sum of Karis 2013, "Real Shading in Unreal Engine 4": this file gives its first factor,
// environmentSpecular() in brdf.h the second.
//
// A probe is a tile of a picture: octahedral maps of the sphere (Cigolle et al. 2014, "A Survey of Efficient
// Representations for Independent Unit Vectors"), one per roughness level. Each map has a border of one texel, which
// repeats what lies beyond the octahedron's edge, so that bilinear filtering has no seam.
//
// Each probe has a box that fits the room around it. What the picture shows is taken to lie on that box.
#ifndef HALFLIGHT_SHADING_REFLECTION_H
#define HALFLIGHT_SHADING_REFLECTION_H

#include "luminance.h"

HL_NAMESPACE_BEGIN

// Maps of a probe, from roughness 0 to 1 in equal steps.
HL_CONST int kReflectionLevels = 5;

// Unit direction to the unit square, +Y in its middle.
HL_FN vec2 octahedronFromDirection(vec3 d)
{
    vec2 p = vec2(d.x, d.z) * (1.0f / (abs(d.x) + abs(d.y) + abs(d.z)));
    vec2 folded =
        vec2((1.0f - abs(p.y)) * (p.x >= 0.0f ? 1.0f : -1.0f), (1.0f - abs(p.x)) * (p.y >= 0.0f ? 1.0f : -1.0f));
    return (d.y < 0.0f ? folded : p) * 0.5f + 0.5f;
}
HL_FN vec3 directionFromOctahedron(vec2 uv)
{
    vec2 p = uv * 2.0f - 1.0f;
    float y = 1.0f - abs(p.x) - abs(p.y);
    float fold = max(-y, 0.0f);
    return normalize(vec3(p.x + (p.x >= 0.0f ? -fold : fold), y, p.y + (p.y >= 0.0f ? -fold : fold)));
}

// Width of a level's map in texels, its border included. `size`: that of level 0, at least 32. Light that is blurred
// much needs few texels, but no fewer than an eighth.
HL_FN int reflectionLevelSize(int size, int level)
{
    return max(size >> level, size >> 3);
}
// Height of a probe's tile, which is `size` wide.
HL_FN int reflectionTileHeight(int size)
{
    return size + (size >> 1);
}
// First texel of a level's map in the probe's tile: level 0 at the top, the others below it, side by side.
HL_FN vec2 reflectionLevelOffset(int size, int level)
{
    int left = level == 4 ? size - (size >> 3) : size - (size >> max(level - 1, 0));
    return vec2(float(level == 0 ? 0 : left), float(level == 0 ? 0 : size));
}
// Where a direction lies in the tile, in texels: texel i covers i … i + 1.
HL_FN vec2 reflectionTexel(int size, int level, vec3 direction)
{
    float inner = float(reflectionLevelSize(size, level) - 2);
    return reflectionLevelOffset(size, level) + 1.0f + octahedronFromDirection(direction) * inner;
}
// Level of a perceptual roughness; between two levels, interpolate.
HL_FN float reflectionLevel(float roughness)
{
    return saturate(roughness) * float(kReflectionLevels - 1);
}
HL_FN float reflectionRoughness(int level)
{
    return float(level) / float(kReflectionLevels - 1);
}

// Where a ray from inside of the cube [-1, 1]^3 leaves it, as a multiple of `direction`. For a point beyond a face,
// that face counts as being as far on its other side. So the way to it shrinks to nothing only at the face itself,
// where walls are, and no ray's end jumps as it turns away from the cube.
HL_FN float distanceToCube(vec3 position, vec3 direction)
{
    vec3 speed = max(abs(direction), vec3(1.0e-12f));
    vec3 way = vec3(abs(direction.x < 0.0f ? position.x + 1.0f : 1.0f - position.x),
                    abs(direction.y < 0.0f ? position.y + 1.0f : 1.0f - position.y),
                    abs(direction.z < 0.0f ? position.z + 1.0f : 1.0f - position.z));
    vec3 t = way / speed;
    return min(min(t.x, t.y), t.z);
}

// Parallax correction: Lagarde and Zanuttini 2012, "Local Image-based Lighting With Parallax-corrected Cubemap". The
// roughness is scaled by distance, as the same solid angle of a lobe is narrower or wider from the probe: Lagarde and
// de Rousiers 2014, "Moving Frostbite to Physically Based Rendering", section 4.9.5. It is at least halved: close to a
// face of the box that is no wall, a narrower lobe would show single bright texels as lines.
//   position, direction          of the reflected ray, in the world; the direction has length 1
//   boxPosition, boxDirection    the same where the probe's box is the cube [-1, 1]^3
//   probe                        where the picture was taken, in the world
// Returns the direction from the probe in xyz, and in w the roughness that blurs as much there.
HL_FN vec4 lookUpReflection(vec3 position, vec3 direction, vec3 boxPosition, vec3 boxDirection, vec3 probe,
                            float roughness)
{
    float distanceFromSurface = distanceToCube(boxPosition, boxDirection);
    vec3 seen = position + direction * distanceFromSurface - probe;
    float distanceFromProbe = max(length(seen), 1.0e-6f);
    float alpha = roughness * roughness * max(distanceFromSurface / distanceFromProbe, 0.5f);
    return vec4(seen * (1.0f / distanceFromProbe), sqrt(min(alpha, 1.0f)));
}

// How much a probe counts at a place: 1 inside its box, 1/4 (0.237) at `fadeMeters` outside of it, 0 from twice that
// on; without a step or a kink, which would be seen as a line. Probes are taken in their order; each leaves 1 -
// coverage of the blend to those after it.
HL_FN float reflectionCoverage(vec3 boxPosition, vec3 halfSizeMeters, float fadeMeters)
{
    vec3 outside = max(abs(boxPosition) - vec3(1.0f), vec3(0.0f)) * halfSizeMeters;
    float within = max(1.0f - 0.25f * dot(outside, outside) / square(fadeMeters), 0.0f);
    return square(square(within)) * within;
}

// Radiance that a specular lobe meets, from what the probes hold.
//
// A probe's picture holds its own place's light. Where something close keeps light from a surface, its reflections are
// darker: the irradiance there over that which the probes expect on the same normal (Lazarov 2013, "Getting More
// Physical in Call of Duty: Black Ops II"). That is a mean over the hemisphere. So a lobe takes part in it by its
// roughness, and a mirror shows its one ray however dark its place is. Where a surface gets more light than expected,
// the picture stays as it is. With its share of alpha, a rough lobe meets what the hemisphere does, which is known
// exactly.
//   fromProbes, expected   prefiltered radiance about the mirror's direction, and of roughness 1 about the normal
//   coverage               of all probes together: where it is small, the picture is of another place
//   trust                  0...1, baked: how far the probes' light serves this place better than its own
//   surroundings, local    what the surface's own irradiance makes of them: irradiance over pi, about the lobe and on
//   the
//                          normal
HL_FN vec3 reflectedSurroundings(vec3 fromProbes, vec3 expected, float coverage, float trust, vec3 surroundings,
                                 vec3 local, float roughness)
{
    float ratio = min(luminanceOf(local) / max(luminanceOf(expected), 1.0e-12f), 1.0f);
    float share = trust * (1.0f - square(square(1.0f - coverage))) * (1.0f - roughness * roughness);
    return mix(surroundings, fromProbes * pow(ratio, roughness), share);
}

HL_NAMESPACE_END

#endif
