// Walks down a light tree: at each node in proportion to the unshadowed light that its children may give. C++ and GLSL
// 4.60 compile this file (halflight/shading/language.h). Tree is a type with this function:
//   LightNode lightNodeAt(Tree, uint node)
#ifndef HALFLIGHT_TRANSPORT_LIGHT_WALK_H
#define HALFLIGHT_TRANSPORT_LIGHT_WALK_H

#include "halflight/shading/gather.h"
#include "halflight/shading/light_tree.h"

HL_NAMESPACE_BEGIN

HL_CONST uint kNoLight = 0xffffffffu;
HL_CONST float kLargestFloat = 3.402823466e38f;
// Nodes of a cut through a tree: two for each sample of a block.
HL_CONST int kMostCutNodes = 32;
// Share of a cut's samples that its nodes take evenly: the probabilities are of one point and used at others near it.
HL_CONST float kEvenCutShare = 0.01f;

// Probability of one of a cut's `count` nodes, of whose importances `total` is the sum.
HL_FN float cutProbability(float importance, float total, int count)
{
    bool usable = total > 0.0f && total <= kLargestFloat;
    float share = (usable ? kEvenCutShare : 1.0f) / float(count);
    return share + (usable ? (1.0f - kEvenCutShare) * importance / total : 0.0f);
}

// Nodes that a walk chooses among: two levels per step, as the bounds of four nodes tell more than those of two. Of a
// child that is a leaf, the leaf itself.
struct LightStep {
    uint node[4];
    float probability[4]; // all zero if no light is in range
    int count;
};

HL_FN_OF(Tree) LightStep lightStepFrom(HL_IN(Tree) tree, uint node, vec3 position, vec3 normal)
{
    LightStep result;
    result.count = 0;
    for (int i = 0; i < 4; ++i) result.probability[i] = 0.0f;
    for (int i = 0; i < 2; ++i) {
        uint child = i == 0 ? node + 1u : lightNodeAt(tree, node).second;
        if (lightNodeAt(tree, child).leaf != 0u) {
            result.node[result.count++] = child;
        } else {
            result.node[result.count++] = child + 1u;
            result.node[result.count++] = lightNodeAt(tree, child).second;
        }
    }
    for (int i = 0; i < result.count; ++i)
        result.probability[i] = lightImportance(lightNodeAt(tree, result.node[i]), position, normal);
    float sum = (result.probability[0] + result.probability[1]) + (result.probability[2] + result.probability[3]);
    if (sum <= 0.0f) return result;
    // If the sum overflowed, even probabilities are unbiased.
    float inverse = 1.0f / sum;
    for (int i = 0; i < result.count; ++i)
        result.probability[i] = sum <= kLargestFloat ? result.probability[i] * inverse : 1.0f / float(result.count);
    return result;
}

struct ChosenLight {
    uint item;
    float probability; // given the node where the walk began; 0 = no light in range
    float u;           // the random number, in 0...1 again
};

HL_FN ChosenLight chosenLight(uint item, float probability, float u)
{
    ChosenLight choice;
    choice.item = item;
    choice.probability = probability;
    choice.u = u;
    return choice;
}

// Whether a node is a light whose range ends before the point.
HL_FN bool lightEndsBefore(HL_IN(LightNode) node, vec3 position, vec3 normal)
{
    return node.range > 0.0f && lightImportance(node, position, normal) <= 0.0f;
}

// `normal` zero = the point receives from all directions.
HL_FN_OF(Tree) ChosenLight sampleLightsBelow(HL_IN(Tree) tree, uint node, vec3 position, vec3 normal, float u)
{
    if (lightNodeAt(tree, node).leaf != 0u && lightEndsBefore(lightNodeAt(tree, node), position, normal))
        return chosenLight(kNoLight, 0.0f, u);
    float probability = 1.0f;
    while (lightNodeAt(tree, node).leaf == 0u) {
        LightStep choices = lightStepFrom(tree, node, position, normal);
        float below = 0.0f;
        int chosen = -1;
        for (int i = 0; i < choices.count; ++i) {
            if (!(choices.probability[i] > 0.0f)) continue;
            if (chosen >= 0) below += choices.probability[chosen];
            chosen = i;
            if (u < below + choices.probability[i]) break;
        }
        if (chosen < 0) return chosenLight(kNoLight, 0.0f, u);
        float share = choices.probability[chosen];
        u = clamp((u - below) / share, 0.0f, kBelowOne);
        probability *= share;
        node = choices.node[chosen];
    }
    return chosenLight(lightNodeAt(tree, node).second, probability, u);
}

// Probability with which a walk that begins `levels` above a leaf ends there.
HL_FN_OF(Tree) float probabilityOfLeaf(HL_IN(Tree) tree, uint leaf, int levels, vec3 position, vec3 normal)
{
    float probability = 1.0f;
    uint node = leaf;
    while (levels > 0) {
        // One level is left if their number is odd.
        bool two = levels % 2 == 0;
        uint parent = lightNodeAt(tree, node).parent;
        uint from = two ? lightNodeAt(tree, parent).parent : parent;
        LightStep choices = lightStepFrom(tree, from, position, normal);
        for (int i = 0; i < choices.count; ++i)
            if (choices.node[i] == node) probability *= choices.probability[i];
        node = from;
        levels -= two ? 2 : 1;
    }
    return probability;
}

HL_NAMESPACE_END

#endif
