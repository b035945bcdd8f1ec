#version 460
#extension GL_GOOGLE_include_directive : require
#include "denoise.glsl"
#include "neighbour_values.glsl"

#include "bake/denoise/outliers.h"

// Interpolated texels lose their share of outliers. They are written, and traced ones read.
void main()
{
    Field field = push.data.field;
    uint texel = texelOfInvocation();
    if (texel >= field.count || !isValid(field, texel) || isTraced(field, texel)) return;
    ClampedTexel clamped = withoutShareOfOutlier(field, texel, clampedLight(field, texel));
    field.clamped.at[texel] = stored(clamped.light);
    vec3 direct = field.estimates.at[texel].direct;
    field.moments.at[texel] = scaledMoment(field.moments.at[texel], direct, clamped);
}
