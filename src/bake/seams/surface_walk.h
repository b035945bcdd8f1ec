// Walks on the surface from texel to texel, within charts and across seams: where a seam joins two charts, places
// beyond the border of one are places on the other, as if both lay unfolded in one plane. C++ and GLSL 4.60 compile
// this file (halflight/shading/language.h). Grid is a type with these functions:
//   ivec2 placeOfTexel(Grid, uint texel)         its column and row
//   uint texelAt(Grid, uint texel, ivec2 place)  the texel at a place on the page of another; kNowhere if there is none
//   on
//                                                the same chart
//   bool chartHasSeams(Grid, uint texel)
//   uint crossingsAround(Grid, uint texel)       bit i: texel i of the 3 × 3 around it, row by row, has crossings and
//   is
//                                                on its chart
//   uint firstCrossing(Grid, uint texel)         among all; that of the next texel ends the texel's crossings
//   SeamCrossing crossingAt(Grid, uint crossing)
#ifndef HALFLIGHT_BAKE_SURFACE_WALK_H
#define HALFLIGHT_BAKE_SURFACE_WALK_H

#include "bake/seams/seam_crossing.h"

HL_NAMESPACE_BEGIN

// Charts that a line to a neighbour may cross: tiles of a texel or two have more, and lose their farthest neighbours.
HL_CONST int kMostSeams = 8;

HL_FN_OF(Grid) vec2 centreOf(HL_IN(Grid) grid, uint texel)
{
    return vec2(placeOfTexel(grid, texel)) + 0.5f;
}

// The texel at an offset on the same chart; kNowhere if there is none.
HL_FN_OF(Grid) uint texelOnChart(HL_IN(Grid) grid, uint texel, ivec2 offset)
{
    return texelAt(grid, texel, placeOfTexel(grid, texel) + offset);
}

// The texel at a place on the page of another; kNowhere if there is none on the same chart.
HL_FN_OF(Grid) uint texelAtPlace(HL_IN(Grid) grid, uint texel, vec2 place)
{
    if (!(place.x >= 0.0f && place.y >= 0.0f)) return kNowhere;
    return texelAt(grid, texel, ivec2(int(place.x), int(place.y)));
}

// The seam that a line to `to` crosses where it leaves the chart at `exit`, beside `texel`: the nearest one that has
// `to` on its other side. kNowhere if there is none.
HL_FN_OF(Grid) uint crossingNear(HL_IN(Grid) grid, uint texel, vec2 exit, vec2 to)
{
    uint nearest = kNowhere;
    float least = 3.0e38f;
    for (uint left = crossingsAround(grid, texel); left != 0u; left &= left - 1u) {
        int i = findLSB(left);
        uint border = texelOnChart(grid, texel, ivec2(i % 3 - 1, i / 3 - 1));
        uint end = firstCrossing(grid, border + 1u);
        for (uint l = firstCrossing(grid, border); l < end; ++l) {
            SeamCrossing crossing = crossingAt(grid, l);
            float distance2 = dot(crossing.place - exit, crossing.place - exit);
            if (distance2 >= least || dot(to - crossing.place, crossing.outward) <= 0.0f) continue;
            least = distance2;
            nearest = l;
        }
    }
    return nearest;
}

// A place on a page, and a texel of the chart that it lies on, or kNowhere.
struct ChartPlace {
    vec2 place;
    uint texel;
};

HL_FN ChartPlace chartPlace(vec2 place, uint texel)
{
    ChartPlace found;
    found.place = place;
    found.texel = texel;
    return found;
}

// The place at an offset where the texel's own chart has nothing.
HL_FN_OF(Grid) ChartPlace placeBeyond(HL_IN(Grid) grid, uint texel, ivec2 offset)
{
    if (!chartHasSeams(grid, texel)) return chartPlace(vec2(0.0f), kNowhere);
    vec2 from = centreOf(grid, texel);
    vec2 to = from + vec2(offset);
    for (int seam = 0; seam <= kMostSeams; ++seam) {
        uint start = texel;
        vec2 line = to - from;
        int steps = max(1, int(ceil(max(abs(line.x), abs(line.y)))));
        int step = 1;
        for (; step <= steps; ++step) {
            uint next = texelAtPlace(grid, start, from + line * (float(step) / float(steps)));
            if (next == kNowhere) break;
            texel = next;
        }
        if (step > steps) return chartPlace(to, texel);
        uint nearest = crossingNear(grid, texel, from + line * ((float(step) - 0.5f) / float(steps)), to);
        if (nearest == kNowhere) break;
        SeamCrossing crossing = crossingAt(grid, nearest);
        to = crossing.targetPlace + crossing.across * (to - crossing.place);
        from = crossing.targetPlace;
        texel = crossing.target;
    }
    return chartPlace(vec2(0.0f), kNowhere);
}

// Texels that bilinear filtering at a place reads, with weights that add up to 1 at most.
struct Footprint {
    uint texels[4];
    float weights[4];
    uint count;
};

// What is at an offset where the texel's own chart has nothing; without texels where no seam leads there.
HL_FN_OF(Grid) Footprint footprintBeyond(HL_IN(Grid) grid, uint texel, ivec2 offset)
{
    Footprint footprint;
    footprint.count = 0u;
    ChartPlace found = placeBeyond(grid, texel, offset);
    if (found.texel == kNowhere) return footprint;
    vec2 base = floor(found.place - 0.5f);
    vec2 f = found.place - 0.5f - base;
    for (int i = 0; i < 4; ++i) {
        vec2 corner = vec2(float(i & 1), float(i >> 1));
        float weight = (corner.x > 0.0f ? f.x : 1.0f - f.x) * (corner.y > 0.0f ? f.y : 1.0f - f.y);
        uint other = texelAtPlace(grid, found.texel, base + corner + 0.5f);
        if (other == kNowhere || weight <= 0.0f) continue;
        footprint.texels[footprint.count] = other;
        footprint.weights[footprint.count++] = weight;
    }
    return footprint;
}

// The texel at an offset, beyond seams the nearest; kNowhere if there is none.
HL_FN_OF(Grid) uint texelOnSurface(HL_IN(Grid) grid, uint texel, ivec2 offset)
{
    uint own = texelOnChart(grid, texel, offset);
    if (own != kNowhere) return own;
    ChartPlace found = placeBeyond(grid, texel, offset);
    uint other = found.texel != kNowhere ? texelAtPlace(grid, found.texel, found.place) : kNowhere;
    return other != texel ? other : kNowhere; // round a closed surface
}

HL_NAMESPACE_END

#endif
