#version 460
#extension GL_GOOGLE_include_directive : require
#include "paths/tables.glsl"

#include "texels.glsl"

layout(local_size_x = 64) in;

// Number of the guide at a point: Guides::guideAt().
uint guideAt(TexelPoint point)
{
    if (point.fragment.hitIndex == kNone) return kNone;
    GpuSurface surface = push.tables.surfaces.at[point.fragment.hitIndex];
    if ((surface.patches & kHasPatches) == 0u) return kNone;
    uint patchId =
        patchAt(surface, false,
                surface.origin + point.barycentric.x * surface.edgeU + point.barycentric.y * surface.edgeV);
    return patchId < push.tables.all.guidedPatches ? push.tables.guideOfPatch.at[patchId] : kNone;
}

// Makes the points of all texels that rays start from, as GatherGroup does, and finds the guide of the first one.
void main()
{
    uint i = invocation();
    uint number = i / uint(kPatternBlock);
    int n = int(i % uint(kPatternBlock));
    if (number >= push.lists.texelCount || push.lists.requests.at[number].blockCount == 0u) return;
    TexelData map =
        TexelData(paths().surfaces, MapTexels(push.lists.mapTexels), Fragments(push.lists.fragments));
    GpuMapTexel mapTexel = map.texels.at[number];
    int pointCount;
    TexelPoint point = texelPoint(map, mapTexel, 0, mapTexel.validPoints, n, pointCount);
    if (n >= pointCount) return;
    if (n == 0) {
        GpuGatherTexel texel;
        texel.id = mapTexel.id;
        texel.firstPoint = i;
        texel.pointCount = uint(pointCount);
        texel.guide = guideAt(point);
        texel.sources = texel.guide != kNone ? push.tables.sourcesOfGuide.at[texel.guide] : 0u;
        push.lists.texels.at[number] = texel;
    }
    // spreadOverSides(): every second point of a mean texel is on the other side.
    float side = (point.fragment.flags & kTexelSideBits) == kMeanTexel && n % 2 == 1 ? -1.0 : 1.0;
    GpuPoint from;
    from.normal = side * point.normal;
    from.geometricNormal = side * point.geometricNormal;
    from.position = point.position + from.geometricNormal * rayEpsilon(point.position, push.tables.scene.scale);
    push.lists.points.at[i] = from;
}
