// Glass with a colour along a ray: what its faces let through, and the volumes between them. Of pipelines that are
// compiled with HALFLIGHT_TINTED.
#ifndef HALFLIGHT_BAKE_GLASS_GLSL
#define HALFLIGHT_BAKE_GLASS_GLSL

#include "halflight/shading/coverage.h"

// A sum of numbers by colour, in units of 2^-20: integers add up in any order.
struct ExactSum
{
    ivec3 whole;
    ivec3 part;
};

// What a ray has passed. PassedGlass of src/bake_cpu/trace.
struct GlassSums
{
    ivec3 depth;     // -log2 of what faces let through, in units of 2^-16
    ExactSum way;    // attenuation times distance where the ray leaves a volume, less that where it enters one
    ExactSum inside; // attenuation of volumes that it enters less that of those that it leaves
    uint last;       // the face before: mask and side
    float lastDistance;
    float end; // of the ray: faces from there on do not count
};

const float kMostDepth = 40.0; // of a face; what passes less than 2^-40 is black

void addExactly(inout ExactSum sum, vec3 value)
{
    vec3 bounded = clamp(value, vec3(-2.0e9), vec3(2.0e9));
    vec3 below = floor(bounded);
    sum.whole += ivec3(below);
    sum.part += ivec3(round((bounded - below) * 1048576.0));
}
vec3 valueOf(ExactSum sum)
{
    return vec3(sum.whole) + vec3(sum.part) / 1048576.0;
}

GlassSums noGlass(float end)
{
    GlassSums sums;
    sums.depth = ivec3(0);
    sums.way.whole = sums.way.part = ivec3(0);
    sums.inside.whole = sums.inside.part = ivec3(0);
    sums.last = 0xffffffffu;
    sums.lastDistance = 0.0;
    sums.end = end;
    return sums;
}

// passed: by colour; above 1 where a face is passed by chance. leaving: attenuation in 1/m of the volume that the ray
// leaves; below 0 where it enters. face: mask and side.
void addFace(inout GlassSums sums, uint face, float distance, vec3 passed, vec3 leaving)
{
    if (distance >= sums.end || (face == sums.last && isSamePlace(sums.lastDistance, distance))) return;
    sums.last = face;
    sums.lastDistance = distance;
    sums.depth += ivec3(round(min(-log2(max(passed, vec3(1.0e-30))), vec3(kMostDepth)) * 65536.0));
    addExactly(sums.way, leaving * distance);
    addExactly(sums.inside, -leaving);
}

// What is left of light from the end of the ray to its origin.
vec3 leftBy(GlassSums sums)
{
    vec3 passed = exp2(-vec3(sums.depth) / 65536.0);
    passed = mix(passed, vec3(0.0), greaterThan(sums.depth, ivec3(int(0.9 * kMostDepth * 65536.0))));
    return glassLeaves(passed, valueOf(sums.way), valueOf(sums.inside), sums.end);
}

#endif
