#version 460
#extension GL_GOOGLE_include_directive : require
#include "gather.glsl"

layout(local_size_x = 64) in;

GpuHalf halves[2];

void add(int stratum, vec3 irradiance, vec3 direction)
{
    uint h = patternHalf(uint(stratum));
    halves[h].irradiance += irradiance;
    halves[h].moment += luminanceOf(irradiance) * direction;
}

// Sums over each block, in the order of the strata: the same bits whatever else is gathered.
void main()
{
    uint block = invocation();
    if (block >= push.lists.blockCount) return;
    for (uint h = 0u; h < 2u; ++h) {
        halves[h].irradiance = vec3(0.0);
        halves[h].moment = vec3(0.0);
    }
    float inverseSquares = 0.0;
    for (int s = 0; s < kPatternBlock; ++s) {
        uint i = rayOf(block, s);
        float distance = push.lists.hits.at[i].distance;
        if (!isinf(distance)) inverseSquares += 1.0 / (distance * distance);
        add(s, push.lists.gathered.at[i], push.lists.rays.at[i].direction);
    }
    if (push.lists.texels.at[push.lists.blocks.at[block].texel].sources > 0u) {
        for (int s = 0; s < kPatternBlock; ++s) {
            uint i = rayOf(block, s);
            GpuRay ray = push.lists.sourceRays.at[i];
            if (ray.tMax < ray.tMin) continue;
            add(s, push.lists.sources.at[i] * push.lists.passed.at[i], ray.direction);
        }
    }
    GpuSums sums;
    sums.halves = halves;
    sums.inverseSquares = inverseSquares;
    push.lists.sums.at[block] = sums;
}
