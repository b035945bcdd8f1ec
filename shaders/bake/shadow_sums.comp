#version 460
#extension GL_GOOGLE_include_directive : require
#include "shadows.glsl"

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
    for (uint n = 0u; n < kShadowHalf; ++n) {
        uint i = rayOf(item, n);
        float weight = push.lists.weights.at[i];
        if (weight == 0.0) continue;
        float passed = push.lists.passed.at[i];
        sum.lit += weight * passed;
        sum.all += weight;
        uint value = uint(passed * float(kLitByte) + 0.5);
        least = min(least, value);
        most = max(most, value);
    }
    sum.range = least | most << 8u;
    push.lists.sums.at[item] = sum;
}
