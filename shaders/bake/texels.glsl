// Texels and their sample points, as texelPoints() makes them.
#ifndef HALFLIGHT_BAKE_TEXELS_GLSL
#define HALFLIGHT_BAKE_TEXELS_GLSL

#include "surfaces.glsl"

#include "bake_gpu/shadows/texel_layout.h"
#include "halflight/shading/texel_points.h"
#include "halflight/shading/validity.h"

layout(buffer_reference, scalar) buffer MapTexels { GpuMapTexel at[]; };
layout(buffer_reference, scalar) buffer Fragments { GpuFragment at[]; };

// Texels of a call, and what they lie on.
struct TexelData
{
    SurfaceData surfaces;
    MapTexels texels;
    Fragments fragments;
};

vec2 pagePlaceOf(TexelData map, GpuFragment fragment, uint corner)
{
    vec2 stored = map.surfaces.places.at[corner];
    if (fragment.instance == kNone) return stored;
    GpuInstance instance = map.surfaces.instances.at[fragment.instance];
    return instance.texelScale * stored + instance.texelOffset;
}
// A texel, its candidates and the number of rounds that they come in.
struct TexelCandidates
{
    GpuMapTexel texel;
    vec2 least;
    vec2 size;
    int rounds;
};

TexelCandidates candidatesOf(TexelData map, GpuMapTexel texel)
{
    TexelCandidates c;
    c.texel = texel;
    c.least = vec2(texel.place & 0xffffu, texel.place >> 16u);
    c.size = vec2(1.0);
    c.rounds = 1;
    float covered = 0.0;
    for (uint f = 0u; f < texel.fragmentCount; ++f) covered += map.fragments.at[texel.firstFragment + f].area;
    if (covered >= kMostlyCovered) return c;
    vec2 low = c.least + c.size;
    vec2 high = c.least;
    for (uint f = 0u; f < texel.fragmentCount; ++f) {
        GpuFragment fragment = map.fragments.at[texel.firstFragment + f];
        uvec3 corners = cornersOf(map.surfaces, fragment.triangle, fragment.instance);
        for (int i = 0; i < 3; ++i) {
            vec2 place = pagePlaceOf(map, fragment, corners[i]);
            low = min(low, place);
            high = max(high, place);
        }
    }
    low = max(low, c.least);
    c.size = max(min(high, c.least + c.size) - low, vec2(0.0));
    c.least = low;
    c.rounds = candidateRounds(c.size, covered);
    return c;
}

struct PageTriangle
{
    vec2 corner;
    vec2 edge1;
    vec2 edge2;
    float area; // signed, twice
};
PageTriangle pageTriangleOf(TexelData map, GpuFragment fragment)
{
    uvec3 corners = cornersOf(map.surfaces, fragment.triangle, fragment.instance);
    PageTriangle t;
    t.corner = pagePlaceOf(map, fragment, corners.x);
    t.edge1 = pagePlaceOf(map, fragment, corners.y) - t.corner;
    t.edge2 = pagePlaceOf(map, fragment, corners.z) - t.corner;
    t.area = t.edge1.x * t.edge2.y - t.edge1.y * t.edge2.x;
    return t;
}
const float kNoArea = 1.0e-20;

// A bit for each of 16 candidates that a triangle covers.
uint coveredCandidates(TexelData map, TexelCandidates c, int first)
{
    const uint all = (1u << uint(kTexelCandidates)) - 1u;
    uint found = 0u;
    for (uint f = 0u; f < c.texel.fragmentCount && found != all; ++f) {
        PageTriangle t = pageTriangleOf(map, map.fragments.at[c.texel.firstFragment + f]);
        if (abs(t.area) < kNoArea) continue;
        float inverse = 1.0 / t.area;
        for (int i = 0; i < kTexelCandidates; ++i) {
            vec2 place = texelCandidate(c.least, c.size, first + i) - t.corner;
            if (isInTriangle(weightsInTriangle(place, t.edge1, t.edge2, inverse))) found |= 1u << uint(i);
        }
    }
    return found;
}

// A sample point, and the triangle that it lies on.
struct TexelPoint
{
    vec3 position;
    vec3 normal;
    vec3 geometricNormal;
    vec2 barycentric;
    GpuFragment fragment;
};

TexelPoint pointOn(TexelData map, GpuFragment fragment, vec2 barycentric)
{
    uvec3 corners = cornersOf(map.surfaces, fragment.triangle, fragment.instance);
    vec3 least = leastWeights(pagePlaceOf(map, fragment, corners.x), pagePlaceOf(map, fragment, corners.y),
                              pagePlaceOf(map, fragment, corners.z));
    TexelPoint p;
    p.fragment = fragment;
    p.barycentric = insetWeights(barycentric, least);
    vec3 weights = vec3(1.0 - p.barycentric.x - p.barycentric.y, p.barycentric);
    p.position = weights.x * positionOf(map.surfaces, fragment.instance, corners.x) + weights.y * positionOf(map.surfaces, fragment.instance, corners.y) +
                 weights.z * positionOf(map.surfaces, fragment.instance, corners.z);
    p.geometricNormal = worldNormal(map.surfaces, fragment.instance, map.surfaces.frames.at[fragment.triangle].normal);
    vec3 n0 = normalOf(map.surfaces, fragment.instance, corners.x);
    vec3 n1 = normalOf(map.surfaces, fragment.instance, corners.y);
    vec3 n2 = normalOf(map.surfaces, fragment.instance, corners.z);
    bool flat_ = n0 == n1 && n0 == n2;
    p.normal = shadingNormalOf(flat_ ? n0 : weights.x * n0 + weights.y * n1 + weights.z * n2, p.geometricNormal);
    return p;
}

// The point of a candidate that some triangle covers.
TexelPoint pointOfCandidate(TexelData map, TexelCandidates c, int number)
{
    vec2 place = texelCandidate(c.least, c.size, number);
    GpuFragment fragment;
    vec2 weights;
    for (uint f = 0u; f < c.texel.fragmentCount; ++f) {
        fragment = map.fragments.at[c.texel.firstFragment + f];
        PageTriangle t = pageTriangleOf(map, fragment);
        if (abs(t.area) < kNoArea) continue;
        weights = weightsInTriangle(place - t.corner, t.edge1, t.edge2, 1.0 / t.area);
        if (isInTriangle(weights)) break;
    }
    return pointOn(map, fragment, weights);
}

// Point `number`, modulo their number, of those points of a batch that `mask` keeps; texelPoints() and keepPoints().
TexelPoint texelPoint(TexelData map, GpuMapTexel texel, int batch, uint mask, int number, out int pointCount)
{
    TexelCandidates c = candidatesOf(map, texel);
    int first = batch * c.rounds * kTexelCandidates;
    // Points are numbered through the rounds: a texel has the first 16.
    int count = 0;
    uint found = 0u;
    for (int round = 0; round < c.rounds && count < kTexelCandidates; ++round) {
        found = coveredCandidates(map, c, first + round * kTexelCandidates);
        count += bitCount(found);
    }
    count = min(count, kTexelCandidates);
    pointCount = 1;
    if (count == 0) {
        // A sliver between all candidates: the centroid of the largest fragment.
        GpuFragment fragment = map.fragments.at[texel.firstFragment];
        return pointOn(map, fragment, fragment.barycentric);
    }
    uint kept = mask & ((1u << uint(count)) - 1u);
    if (kept == 0u) kept = 1u; // rounding: the processor has found more points
    pointCount = bitCount(kept);
    int point = nthBit(kept, number % pointCount);
    for (int round = 0; round < c.rounds; ++round) {
        if (c.rounds > 1) found = coveredCandidates(map, c, first + round * kTexelCandidates);
        int here = bitCount(found);
        if (point < here)
            return pointOfCandidate(map, c, first + round * kTexelCandidates + nthBit(found, point));
        point -= here;
    }
    return pointOfCandidate(map, c, first); // never
}

#endif
