#version 460
#extension GL_GOOGLE_include_directive : require
#include "gather.glsl"

layout(local_size_x = 64) in;

// Makes the gather rays of all blocks, as RayBundle::trace() does.
void main()
{
    uint i = invocation();
    uint block;
    int stratum;
    bool inside = sampleOf(i, block, stratum);
    if (i >= rayCount()) return;
    GpuRay ray = noRay();
    if (inside) {
        GpuBlock b = push.lists.blocks.at[block];
        GpuGatherTexel texel = push.lists.texels.at[b.texel];
        GpuPoint point = pointOf(texel, b.number, stratum);
        uint bits = patternPoint(hashCombine(push.tables.all.seed, texel.id), b.number, stratum);
        vec2 r = push.tables.radii.at[(bits & 0xffffu) >> uint(16 - kPatternAngleBits)];
        vec2 a = push.tables.angles.at[bits >> uint(32 - kPatternAngleBits)];
        vec3 tangent;
        vec3 bitangent;
        orthonormalBasis(point.normal, tangent, bitangent);
        vec3 direction = r.x * a.x * tangent + r.x * a.y * bitangent + r.y * point.normal;
        ray.origin = point.position;
        ray.direction = outOfSurface(direction, point.geometricNormal);
        ray.tMax = kLongestRay;
    }
    push.lists.rays.at[i] = ray;
}
