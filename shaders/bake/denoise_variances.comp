#version 460
#extension GL_GOOGLE_include_directive : require
#include "denoise.glsl"

#include "bake/denoise/texel_variance.h"

// The calibrated variance of a texel's gathered light.
void main()
{
    Field field = push.data.field;
    uint texel = texelOfInvocation();
    if (texel >= field.count || !isValid(field, texel)) return;
    field.variances.at[texel] = statedLight(field, texel).variance * varianceScaleAt(field, texel);
}
