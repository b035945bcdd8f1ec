// Where rays start.
#ifndef HALFLIGHT_SHADING_RAYS_H
#define HALFLIGHT_SHADING_RAYS_H

#include "language.h"

HL_NAMESPACE_BEGIN

// Offset of ray origins along the normal, in metres. It grows with the coordinates, so it exceeds their rounding error.
// `sceneScale`: diagonal of the scene's bounds.
HL_FN float rayEpsilon(vec3 position, float sceneScale)
{
    float magnitude = max(max(abs(position.x), abs(position.y)), abs(position.z));
    return max(8.0e-7f * magnitude, 2.0e-6f * sceneScale);
}

// Normal of a point of a triangle for shading, from the sum of its vertex normals: the geometric normal where the sum
// points to the back. (Smooth normals on coarse meshes, and files whose normals contradict the winding, would put the
// hemisphere inside the surface.)
HL_FN vec3 shadingNormalOf(vec3 sum, vec3 geometricNormal)
{
    float size = length(sum);
    vec3 normal = size > 0.0f ? sum * (1.0f / size) : geometricNormal;
    return dot(normal, geometricNormal) > 0.0f ? normal : geometricNormal;
}

// A triangle's point on the curved surface that its vertex normals describe, as origin of shadow rays, so that the
// terminator does not show the triangles (Hanika 2021, "Hacking the Shadow Terminator", Ray Tracing Gems II, chapter
// 4). `weights`: of the corners; `side`: the geometric normal where the light is; `turned`: that is the back.
HL_FN vec3 pointOnCurvedSurface(vec3 position, vec3 weights, vec3 corners0, vec3 corners1, vec3 corners2, vec3 normals0,
                                vec3 normals1, vec3 normals2, vec3 side, bool turned)
{
    if (normals0 == normals1 && normals0 == normals2) return position;
    vec3 n0 = turned ? -normals0 : normals0;
    vec3 n1 = turned ? -normals1 : normals1;
    vec3 n2 = turned ? -normals2 : normals2;
    if (dot(n0, side) <= 0.0f || dot(n1, side) <= 0.0f || dot(n2, side) <= 0.0f) return position;
    vec3 curved = position;
    curved -= weights.x * min(0.0f, dot(position - corners0, n0)) * n0;
    curved -= weights.y * min(0.0f, dot(position - corners1, n1)) * n1;
    curved -= weights.z * min(0.0f, dot(position - corners2, n2)) * n2;
    return curved;
}
// An origin that is raised by no more than so many offsets of rays cannot be behind another surface.
HL_CONST float kLeastLift = 4.0f;

HL_NAMESPACE_END

#endif
