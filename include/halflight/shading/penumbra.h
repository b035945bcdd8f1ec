// Penumbrae of realtime shadows, as wide as the light's size and the distance to the caster make them: Fernando 2005,
// "Percentage-Closer Soft Shadows". A search around the receiver finds the mean distance of its casters, and the
// comparisons with the shadow map are averaged over the picture of the source that a pinhole in the caster would throw.
// A straight edge then has the profile that the bake finds by rays: the part of the source on the edge's lit side.
#ifndef HALFLIGHT_SHADING_PENUMBRA_H
#define HALFLIGHT_SHADING_PENUMBRA_H

#include "language.h"

HL_NAMESPACE_BEGIN

// Wider kernels would need more comparisons than a frame can pay for.
HL_CONST float kWidestPenumbraTexels = 32.0f;
// How many times as far as others a receiver moves along its normal where the light meets it edge-on.
HL_CONST float kEdgeOnShift = 4.0f;

// Comparisons of a kernel of this half-width: two for each texel of it, so that the ramps of neighbouring ones
// (bilinear ones are a texel wide) meet across a straight edge, and at least 16.
HL_FN int penumbraTaps(float texels)
{
    return max(int(2.0f * texels + 0.5f), 16);
}

// Largest half-width of a kernel in a shadow map of this size, in texels: wider penumbrae are cut to it. The map's
// border has this width, so small maps have a narrow one.
HL_FN float penumbraReach(float mapTexels)
{
    return min(kWidestPenumbraTexels, mapTexels / 16.0f);
}

// Half-width of a penumbra over half the source's width, both in metres and across the light's axis. Distances are from
// the light along that axis.
HL_FN float penumbraOfSource(float receiverMeters, float casterMeters)
{
    return max(receiverMeters - casterMeters, 0.0f) / max(casterMeters, 1.0e-4f);
}

// Half-width in texels that a disk of comparisons needs, so that its variance along an axis, r^2 / 4, and that of a
// bilinear comparison, 1 / 6, together are that of a disk of this half-width.
HL_FN float diskOfComparisons(float texels)
{
    return sqrt(max(texels * texels - 2.0f / 3.0f, 0.0f));
}

// Half-width in texels of the disk whose variance is that of a tent of half-width h, h^2 / 6. Narrower penumbrae take
// the tent.
HL_FN float diskLikeTent(float tentHalfWidth)
{
    return tentHalfWidth * 0.816496581f; // sqrt(2 / 3)
}

// Distance from the middle of point i of n, spread evenly over the unit disk: Vogel 1979, "A better way to construct
// the sunflower head". Each point lies the golden angle further than the one before.
HL_FN float sunflowerRadius(int i, int n)
{
    return sqrt((float(i) + 0.5f) / float(n));
}
// The same for the places of a search: half of them lie in the outermost 16 % of the radius, so that a straight edge
// that hides 6 % of the source or more is found by 16 places, whatever its direction; spread evenly, these would miss
// 10 %.
HL_FN float searchRadius(int i, int n)
{
    return sqrt(sunflowerRadius(i, n));
}
HL_CONST vec2 kGoldenTurn = vec2(-0.737368878f, 0.675490294f); // cosine and sine of the golden angle, pi (3 - sqrt 5)
HL_FN vec2 turnByGoldenAngle(vec2 v)
{
    return vec2(v.x * kGoldenTurn.x - v.y * kGoldenTurn.y, v.x * kGoldenTurn.y + v.y * kGoldenTurn.x);
}

// Point i of n, spread evenly over the square [-1, 1]^2: a Hammersley set with the golden ratio, whose projections on
// both axes are even too.
HL_FN vec2 squarePoint(int i, int n)
{
    float y = float(i) * 0.618033989f + 0.5f;
    return vec2((float(i) + 0.5f) / float(n), y - floor(y)) * 2.0f - vec2(1.0f);
}

// Part of a disk of half-width 1 beyond a straight line at this signed distance from its middle: what a point sees of a
// round source whose edge is hidden by a straight one.
HL_FN float diskBeyond(float distance)
{
    float d = clamp(distance, -1.0f, 1.0f);
    return (acos(d) - d * sqrt(1.0f - d * d)) / kShadingPi;
}

HL_NAMESPACE_END

#endif
