#version 460
#extension GL_GOOGLE_include_directive : require
#include "../gather.glsl"

#include "../block_sums.glsl"

layout(local_size_x = 64) in;

// Sums over each block of what samples of emitters and the sky bring.
void main()
{
    uint block = invocation();
    if (block >= push.lists.blockCount) return;
    beginSums();
    addSources(block);
    push.lists.emitted.at[block].at = halves;
}
