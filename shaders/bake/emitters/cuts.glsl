// Cuts through the tree of emitters, one for each texel: LightTree::Cut.
#ifndef HALFLIGHT_BAKE_EMITTER_CUTS_GLSL
#define HALFLIGHT_BAKE_EMITTER_CUTS_GLSL

#include "../paths/emitters.glsl"

uint cutPlace(uint texel, uint number)
{
    return number * push.lists.texelCount + texel;
}

// LightTree::sample() of a cut.
ChosenLight sampleCut(uint texel, vec3 position, vec3 normal, float u)
{
    GpuCutNode chosen = push.lists.cuts.at[cutPlace(texel, 0u)];
    float below = 0.0;
    for (uint i = 1u; i < paths().all.cutNodes && u >= below + chosen.probability; ++i) {
        below += chosen.probability;
        chosen = push.lists.cuts.at[cutPlace(texel, i)];
    }
    float rest = clamp((u - below) / chosen.probability, 0.0, kBelowOne);
    ChosenLight result = sampleLightsBelow(paths().emitterTree, chosen.node, position, normal, rest);
    result.probability *= chosen.probability;
    return result;
}

// Emitters::pdfArea() of a cut.
float cutPdfArea(uint texel, uint emitter, vec3 position, vec3 normal)
{
    if (emitter == kNone) return 0.0;
    LightTree tree = paths().emitterTree;
    uint leaf = paths().leafOfEmitter.at[emitter];
    if (lightEndsBefore(tree.at[leaf], position, normal)) return 0.0;
    int levels = 0;
    for (uint n = leaf; n != kNone; n = tree.at[n].parent) {
        for (uint i = 0u; i < paths().all.cutNodes; ++i) {
            GpuCutNode top = push.lists.cuts.at[cutPlace(texel, i)];
            if (top.node != n) continue;
            return probabilityOfLeaf(tree, leaf, levels, position, normal) * top.probability *
                   paths().emitters.at[emitter].inverseArea;
        }
        ++levels;
    }
    return 0.0;
}

#endif
