#version 460
#extension GL_GOOGLE_include_directive : require
#include "radiosity.glsl"

#include "../texels.glsl"

layout(local_size_x = 64) in;

const uint kTrianglePoints = kPatchPoints - 1u;

// TexelGroup::triangles().
GpuPatchPoint pointOnTriangle(uint face, int number)
{
    vec2 b = r2Point(number);
    if (b.x + b.y > 1.0) b = vec2(1.0) - b;
    PathSurface s = surfaceAt(face, b);
    return GpuPatchPoint(s.position, s.normal, s.geometricNormal, b, face, kNone);
}

// A point of texelPoints(), perhaps on the back.
GpuPatchPoint pointOfTexel(TexelPoint p, bool back)
{
    float side = back ? -1.0 : 1.0;
    uint face = p.fragment.hitIndex == kNone || !back ? p.fragment.hitIndex : p.fragment.hitIndex | kBackBit;
    return GpuPatchPoint(p.position, side * p.normal, side * p.geometricNormal, p.barycentric, face, kNone);
}

// Makes the sample points of all items, as TexelGroup does, and finds what the pass fills from them.
void main()
{
    uint i = invocation();
    uint number = i / kPatchPoints;
    int n = int(i % kPatchPoints);
    if (number >= work().itemCount) return;
    uint kind = work().pass.kind;
    GpuRadiosityItem request = work().requests.at[number];
    GpuPatchItem item = GpuPatchItem(0u, 0u, 0u, request.group);
    GpuPatchPoint point;
    if (kind == kTrianglesPass) {
        item.id = request.id;
        item.pointCount = kTrianglePoints;
        point = pointOnTriangle(request.face, n);
    } else {
        TexelData map =
            TexelData(paths().surfaces, MapTexels(work().mapTexels), Fragments(work().fragments));
        GpuMapTexel texel = map.texels.at[number];
        bool back = kind == kBacksPass || kind == kBackElementsPass;
        uint mask = back ? 0xffffu : texel.validPoints;
        item.id = texel.id;
        if (mask != 0u) {
            int count;
            point = pointOfTexel(texelPoint(map, texel, 0, mask, n, count), back);
            float covered = 0.0;
            for (uint f = 0u; f < texel.fragmentCount; ++f) covered += map.fragments.at[texel.firstFragment + f].area;
            item.pointCount = uint(count);
            item.whole = uint(count) == kPatchPoints && covered > kWholeTexel ? 1u : 0u;
        }
    }
    point.source = kNone;
    if (uint(n) < item.pointCount && point.face != kNone) point.source = sourceAt(point.face, point.barycentric);
    work().points.at[i] = point;
    if (n == 0) work().items.at[number] = item;
}
