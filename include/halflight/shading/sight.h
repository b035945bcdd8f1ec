// Whether a probe sees a point: as in Majercik et al. 2019, "Dynamic Diffuse Global Illumination with Ray-Traced
// Irradiance Fields", a map over all directions says how near surfaces are, and Chebyshev's inequality (its one-sided
// form) bounds the share of directions in which the probe sees farther than the point. Two differences make walls seen
// at grazing angles as sharp as others. Nearness is 1 / distance in the octahedron's norm |x| + |y| + |z|: for a plane
// it is linear on each face of the octahedron, so linear interpolation between the corners of a subdivided face gives
// it exactly. And the deviation is that from the interpolated nearness: 0 for a plane, large at edges alone.
#ifndef HALFLIGHT_SHADING_SIGHT_H
#define HALFLIGHT_SHADING_SIGHT_H

#include "language.h"

HL_NAMESPACE_BEGIN

// Weight of a probe that sees nothing of a point, against one that sees it. It is not 0: where no probe sees a point,
// all count as without maps.
HL_CONST float kLeastSight = 0.002f;
// Smallest deviation, over the nearness: what curved surfaces and the map's rounding are off by.
HL_CONST float kLeastSightDeviation = 0.005f;

// The octahedral map (Cigolle et al. 2014, "A Survey of Efficient Representations for Independent Unit Vectors"): where
// direction d, of any length above 0, lies in the square -1...1. d.z >= 0 fills the diamond in the middle.
HL_FN float octahedralX(vec3 d)
{
    float size = abs(d.x) + abs(d.y) + abs(d.z);
    float side = d.x >= 0.0f ? 1.0f : -1.0f;
    return d.z >= 0.0f ? d.x / size : side * (1.0f - abs(d.y) / size);
}
HL_FN float octahedralY(vec3 d)
{
    float size = abs(d.x) + abs(d.y) + abs(d.z);
    float side = d.y >= 0.0f ? 1.0f : -1.0f;
    return d.z >= 0.0f ? d.y / size : side * (1.0f - abs(d.x) / size);
}
// The direction at a place of the square, not normalized.
HL_FN vec3 octahedralDirection(float x, float y)
{
    float z = 1.0f - abs(x) - abs(y);
    float fold = max(-z, 0.0f);
    return vec3(x >= 0.0f ? x - fold : x + fold, y >= 0.0f ? y - fold : y + fold, z);
}

// The map's corners are equally spaced on the square, an odd number along each side. Each cell between four of them is
// halved along a diagonal, so that edges of the octahedron lie on edges of the triangles. Share of the corner at column
// and row (0 or 1) of a cell, for a place at (u, v) in 0...1 from the corner at 0, 0. `mirrored`: x y < 0 in the cell.
HL_FN float octahedralShare(int column, int row, float u, float v, bool mirrored)
{
    float across = mirrored ? 1.0f - u : u;
    int side = mirrored ? 1 - column : column;
    if (side == row) return max(row == 0 ? 1.0f - across - v : across + v - 1.0f, 0.0f);
    return row == 0 ? min(across, 1.0f - v) : min(v, 1.0f - across);
}

// Weight of a probe for a point, kLeastSight...1. `nearness` and `variance` are the map's in the direction of the
// point, `pointNearness` is the point's, all times the range of the map. The cube is Majercik et al.'s: it darkens what
// leaks through the bound.
HL_FN float probeSight(float nearness, float variance, float pointNearness)
{
    float least = kLeastSightDeviation * nearness;
    float spread = max(variance, least * least);
    float excess = max(nearness - pointNearness, 0.0f);
    float bound = spread / (spread + excess * excess);
    return max(bound * bound * bound, kLeastSight);
}

HL_NAMESPACE_END

#endif
