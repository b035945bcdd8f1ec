#version 460
#extension GL_GOOGLE_include_directive : require
#include "../paths/tables.glsl"

#include "halflight/shading/sobol.h"

layout(local_size_x = 64) in;

bool isFinite(vec3 v)
{
    return !any(isinf(v)) && !any(isnan(v));
}

// How many emitter samples each block of a texel takes beside the light that the texel has gathered with it and the
// blocks before: the roulette of NextEvent::sampleEmitters().
void main()
{
    uint texel = invocation();
    if (texel >= push.lists.texelCount) return;
    GpuGatherRequest of = push.lists.requests.at[texel];
    float sky = paths().all.brightIlluminance;
    float expected = sky + (paths().all.cutNodes > 0u && of.blockCount > 0u ? push.lists.cutTotals.at[texel] : 0.0);
    GpuEmitterShare share;
    share.sky = sky <= 0.0 ? 0.0 : paths().all.cutNodes == 0u ? 1.0 : sky / expected;
    const float ofHalf = 2.0 / float(kPatternBlock);
    for (uint b = of.firstBlock; b < of.firstBlock + of.blockCount; ++b) {
        GpuSums sums = push.lists.sums.at[b];
        for (int h = 0; h < 2; ++h) {
            // BlockSums::end().
            vec3 irradiance = sums.halves[h].irradiance * ofHalf;
            if (isFinite(irradiance) && isFinite(sums.halves[h].moment * ofHalf)) of.gathered += irradiance;
            ++of.halfBlocks;
        }
        share.survival = rouletteSurvival(expected, luminanceOf(of.gathered / float(of.halfBlocks)));
        push.lists.shares.at[b] = share;
    }
}
