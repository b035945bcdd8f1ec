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
        ray.origin = point.position;
        ray.direction = patternDirection(bits, point.normal, point.geometricNormal);
        ray.tMax = kLongestRay;
    }
    push.lists.rays.at[i] = ray;
}
