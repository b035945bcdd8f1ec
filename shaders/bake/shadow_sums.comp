#version 460
#extension GL_GOOGLE_include_directive : require
#include "shadows.glsl"

#include "halflight/shading/luminance.h"

layout(local_size_x = 64) in;

// Sums over each half-batch, in the order of its rays: LitSum::add().
void main()
{
    uint item = invocationOf(kGroupSize);
    if (item >= push.lists.itemCount) return;
    GpuLitSum sum;
    sum.lit = 0.0;
    sum.all = 0.0;
    uint least = kLitByte;
    uint most = 0u;
    vec3 colors = vec3(0.0);
    bool tinted = push.tables.tinted != 0u;
    for (uint n = 0u; n < kShadowHalf; ++n) {
        uint i = rayOf(item, n);
        float weight = push.lists.weights.at[i];
        if (weight == 0.0) continue;
        vec3 color = tinted ? Vectors(uvec2(push.lists.passed)).at[i] : vec3(1.0);
        float passed = tinted ? grayOf(color) : push.lists.passed.at[i];
        colors += weight * color;
        sum.lit += weight * passed;
        sum.all += weight;
        uint value = uint(passed * float(kLitByte) + 0.5);
        least = min(least, value);
        most = max(most, value);
    }
    sum.range = least | most << 8u;
    push.lists.sums.at[item] = sum;
    if (tinted) push.lists.colors.at[item] = colors;
}
