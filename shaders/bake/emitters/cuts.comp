#version 460
#extension GL_GOOGLE_include_directive : require
#include "cuts.glsl"

layout(local_size_x = 64) in;

uint node[kMostCutNodes];
float importance[kMostCutNodes];
float toOpen[kMostCutNodes]; // importance, negative for leaves

void setNode(uint place, uint number, GpuPoint point)
{
    LightNode of = lightNodeAt(paths().emitterTree, number);
    node[place] = number;
    importance[place] = lightImportance(of, point.position, point.normal);
    // Which is 0 if it is no number.
    toOpen[place] = of.leaf != 0u ? -1.0 : importance[place] > 0.0 ? importance[place] : 0.0;
}

// Opens the tree of emitters for each texel: LightTree::cut().
void main()
{
    uint texel = invocation();
    if (texel >= push.lists.texelCount) return;
    if (push.lists.requests.at[texel].blockCount == 0u) return;
    GpuPoint point = push.lists.points.at[push.lists.texels.at[texel].firstPoint];
    uint count = paths().all.cutNodes;
    setNode(0u, 0u, point);
    for (uint n = 1u; n < count; ++n) {
        uint widest = 0u;
        for (uint i = 1u; i < n; ++i)
            if (toOpen[i] > toOpen[widest]) widest = i;
        uint opened = node[widest];
        setNode(widest, opened + 1u, point);
        setNode(n, paths().emitterTree.at[opened].second, point);
    }
    float total = 0.0;
    for (uint i = 0u; i < count; ++i) total += importance[i];
    for (uint i = 0u; i < count; ++i) {
        GpuCutNode part;
        part.node = node[i];
        part.probability = cutProbability(importance[i], total, int(count));
        push.lists.cuts.at[cutPlace(texel, i)] = part;
    }
    push.lists.cutTotals.at[texel] = total;
}
