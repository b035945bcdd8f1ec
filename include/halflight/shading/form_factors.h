// Rays of form factors and of the search for occluders: which strata they take, and the borders of elements.
#ifndef HALFLIGHT_SHADING_FORM_FACTORS_H
#define HALFLIGHT_SHADING_FORM_FACTORS_H

#include "language.h"

HL_NAMESPACE_BEGIN

// Rays shorter than this many widths would show that the radiance of a patch or element is constant.
HL_CONST float kNearestInPatches = 0.5f;
HL_CONST float kNearestInElements = 0.5f * kNearestInPatches; // which are not split again

// Rays that search for occluders end short of their targets, which lie on other surfaces perhaps.
HL_CONST float kShortOfTarget = 0.999f;
// Texels covered by more than this are whole texels, but for rounding.
HL_CONST float kWholeTexel = 0.999f;

// Stratum of ray `number` of a texel that takes four rays for each of `diagonals`: 1, 2 or 4. Four have one in each row
// and column of the pattern. Consecutive groups of texels take complementary strata.
HL_FN int factorStratum(int number, int diagonals, uint group)
{
    uint d = uint(number) / 4u;
    uint x = uint(number) % 4u;
    uint flip = diagonals == 1 ? group & 3u : diagonals == 2 ? (group & 1u) ^ (2u * d) : d;
    return int((x << 2u) | (x ^ flip));
}

// Corners (even numbers) and middles of edges (odd ones) of the unit square, about it, 0 to 7.
HL_FN float alongBorder(int number)
{
    return number <= 2 ? 0.5f * float(number) : number <= 4 ? 1.0f : number <= 6 ? 0.5f * float(6 - number) : 0.0f;
}
HL_FN vec2 placeOnBorder(int number)
{
    return vec2(alongBorder(number), alongBorder((number + 6) % 8));
}

// From a place, in patches, to a corner or an edge of its element, whose width is `size` patches.
HL_FN vec2 wayToBorder(vec2 at, float size, int number)
{
    return size * floor(at / size) + size * placeOnBorder(number) - at;
}

// Signed area of a triangle's parallelogram by its edges on the page, or in patches.
HL_FN float areaOfEdges(vec2 edgeU, vec2 edgeV)
{
    return edgeU.x * edgeV.y - edgeU.y * edgeV.x;
}
// A way in patches as one in the world, on the plane of a triangle with two edges. Their area is not zero.
HL_FN vec3 wayOnTriangle(vec2 way, vec2 edgeU, vec2 edgeV, vec3 edge1, vec3 edge2)
{
    return (areaOfEdges(way, edgeV) * edge1 + areaOfEdges(edgeU, way) * edge2) / areaOfEdges(edgeU, edgeV);
}

HL_NAMESPACE_END

#endif
