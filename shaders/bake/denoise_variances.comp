#version 460
#extension GL_GOOGLE_include_directive : require
#include "denoise.glsl"

#include "bake/denoise/texel_variance.h"

// A texel's signals, with the calibrated variance.
void main()
{
    Field field = push.data.field;
    uint texel = texelOfInvocation();
    if (texel >= field.count || !isValid(field, texel)) return;
    NoisyLight gathered = statedLight(field, texel);
    gathered.variance *= varianceScaleAt(field, texel);
    field.scaled.at[texel] = stored(gathered);
    GpuEstimate estimate = field.estimates.at[texel];
    field.moments.at[texel] = estimate.moment;
    if (field.hasDirect != 0u) field.direct.at[texel] = stored(directLight(estimate.direct, estimate.varianceOfDirect));
}
