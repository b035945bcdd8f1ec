#version 460
#extension GL_GOOGLE_include_directive : require
#include "sums.glsl"

layout(local_size_x = 64) in;

// Light of samples of emitters and of the sky's bright part.
void main()
{
    uint place;
    uint block;
    uint component;
    if (!sumsOf(place, block, component)) return;
    beginSums();
    for (int s = 0; s < kPatternBlock; ++s) {
        uint i = rayOf(block, s);
        GpuRay ray = push.lists.sourceRays.at[i];
        if (ray.tMax < ray.tMin || push.lists.sourceLights.at[i].lit != component) continue;
        addToSums(s, push.lists.sources.at[i] * passedOf(i), ray.direction);
    }
    push.lists.componentEmitted.at[place].at = halves;
}
