// Sample points of texels: candidates, which of them a triangle covers, and where on it they lie. Places on a page are
// in texels; barycentric weights are those of vertices 1 and 2.
#ifndef HALFLIGHT_SHADING_TEXEL_POINTS_H
#define HALFLIGHT_SHADING_TEXEL_POINTS_H

#include "random.h"

HL_NAMESPACE_BEGIN

HL_CONST int kTexelCandidates = 16; // of a batch, and the most points of a texel

// A texel with a smaller coverage is at the rim of its surface.
HL_CONST float kMostlyCovered = 0.6f;
// Texels between an edge and places that lie within it, despite rounding.
HL_CONST float kInsetTexels = 4.0e-3f;

// Candidates of a texel that is partly covered fill the bounds of the covered part, in as many rounds as yield about
// one batch of covered points, but at most one for each point. `covered`: share of the texel's square.
HL_FN int candidateRounds(vec2 size, float covered)
{
    return int(clamp(size.x * size.y / max(covered, 1.0e-6f) + 0.5f, 1.0f, float(kTexelCandidates)));
}

// Candidate `number` in the rectangle from `least` on: the R2 sequence. Its first point would be the centre, where
// planes of other surfaces often lie: it is beside them, in no symmetric direction.
HL_FN vec2 texelCandidate(vec2 least, vec2 size, int number)
{
    vec2 place = least + size * r2Point(number);
    return number == 0 ? place + kInsetTexels * vec2(1.0f, 0.5f) : place;
}

// Barycentric weights of a place, relative to vertex 0 of a triangle with two edges from there.
HL_FN vec2 weightsInTriangle(vec2 place, vec2 edge1, vec2 edge2, float inverseArea)
{
    return vec2((place.x * edge2.y - place.y * edge2.x) * inverseArea,
                (edge1.x * place.y - edge1.y * place.x) * inverseArea);
}
HL_FN bool isInTriangle(vec2 weights)
{
    return min(min(weights.x, weights.y), 1.0f - (weights.x + weights.y)) >= 0.0f;
}

// Barycentric weights of all vertices of points that are kInsetTexels from the triangle's edges. Weights are distances
// over the triangle's heights, and a height is twice the area over an edge.
HL_FN vec3 leastWeights(vec2 a, vec2 b, vec2 c)
{
    vec2 edge1 = b - a;
    vec2 edge2 = c - a;
    float weightOfEdge = kInsetTexels / max(abs(edge1.x * edge2.y - edge1.y * edge2.x), 1.0e-12f);
    return min(weightOfEdge * vec3(length(b - c), length(c - a), length(a - b)), vec3(1.0f / 3.0f));
}
// The weights of a point, moved to at least `least`. A ray that starts on an edge between two walls lies in the plane
// of the other wall, and can miss it.
HL_FN vec2 insetWeights(vec2 weights, vec3 least)
{
    float w = 1.0f - weights.x - weights.y;
    if (w >= least.x && weights.x >= least.y && weights.y >= least.z) return weights;
    vec3 inset = max(vec3(w, weights.x, weights.y), least);
    return vec2(inset.y, inset.z) * (1.0f / (inset.x + inset.y + inset.z));
}

HL_NAMESPACE_END

#endif
