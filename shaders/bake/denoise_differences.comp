#version 460
#extension GL_GOOGLE_include_directive : require
#include "denoise.glsl"

#include "bake/denoise/texel_variance.h"

// What second differences say of a texel's noise.
void main()
{
    Field field = push.data.field;
    uint texel = texelOfInvocation();
    if (texel >= field.count) return;
    field.differences.at[texel] = secondDifference(field, texel);
}
