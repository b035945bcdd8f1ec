#version 460
#extension GL_GOOGLE_include_directive : require
#include "../paths/tables.glsl"

#include "halflight/shading/sobol.h"

layout(local_size_x = 64) in;

bool isFinite(vec3 v)
{
    return !any(isinf(v)) && !any(isnan(v));
}

// Illuminance beside which a texel's emitters are sampled, by block: the least that a component with emitters or a
// bright sky has of itself, with the block and those before. It is kept in the blocks' shares.
// NextEvent::besideEmitters().
void findLeastOfComponents(uint texel, GpuGatherRequest of)
{
    const float ofHalf = 2.0 / float(kPatternBlock);
    uint components = push.tables.all.components;
    for (uint c = 0u; c < components; ++c) {
        if ((push.tables.all.emittingComponents >> c & 1u) == 0u) continue;
        bool isFirst = (push.tables.all.emittingComponents & ((1u << c) - 1u)) == 0u;
        vec3 gathered = push.lists.gatheredBefore.at[texel * components + c];
        uint halfBlocks = of.halfBlocks;
        for (uint b = of.firstBlock; b < of.firstBlock + of.blockCount; ++b) {
            for (int h = 0; h < 2; ++h) {
                GpuHalf sums = push.lists.componentSums.at[b * components + c].at[h];
                vec3 irradiance = sums.irradiance * ofHalf;
                if (isFinite(irradiance) && isFinite(sums.moment * ofHalf)) gathered += irradiance;
                ++halfBlocks;
            }
            float mean = luminanceOf(gathered / float(halfBlocks));
            push.lists.shares.at[b].survival = isFirst ? mean : min(push.lists.shares.at[b].survival, mean);
        }
    }
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
    bool byComponent = push.tables.all.components > 0u;
    if (byComponent) findLeastOfComponents(texel, of);
    const float ofHalf = 2.0 / float(kPatternBlock);
    for (uint b = of.firstBlock; b < of.firstBlock + of.blockCount; ++b) {
        GpuSums sums = push.lists.sums.at[b];
        for (int h = 0; h < 2; ++h) {
            // BlockSums::end().
            vec3 irradiance = sums.halves[h].irradiance * ofHalf;
            if (isFinite(irradiance) && isFinite(sums.halves[h].moment * ofHalf)) of.gathered += irradiance;
            ++of.halfBlocks;
        }
        float gathered =
            byComponent ? push.lists.shares.at[b].survival : luminanceOf(of.gathered / float(of.halfBlocks));
        share.survival = rouletteSurvival(expected, gathered);
        push.lists.shares.at[b] = share;
    }
}
