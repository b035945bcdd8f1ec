#version 460
#extension GL_GOOGLE_include_directive : require
#include "gather.glsl"

#include "block_sums.glsl"

layout(local_size_x = 64) in;

// Sums over each block of what its gather rays and samples of secondary sources bring.
void main()
{
    uint block = invocation();
    if (block >= push.lists.blockCount) return;
    beginSums();
    float inverseSquares = 0.0;
    for (int s = 0; s < kPatternBlock; ++s) {
        uint i = rayOf(block, s);
        float distance = push.lists.hits.at[i].distance;
        if (!isinf(distance)) inverseSquares += 1.0 / (distance * distance);
        addToSums(s, push.lists.gathered.at[i], push.lists.rays.at[i].direction);
    }
    if (push.lists.texels.at[push.lists.blocks.at[block].texel].sources > 0u) addSources(block);
    GpuSums sums;
    sums.halves = halves;
    sums.inverseSquares = inverseSquares;
    push.lists.sums.at[block] = sums;
}
