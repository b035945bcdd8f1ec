#version 460
#extension GL_GOOGLE_include_directive : require
#include "denoise.glsl"
#include "neighbour_values.glsl"

#include "bake/denoise/outliers.h"

// Fireflies and dark specks go.
void main()
{
    Field field = push.data.field;
    uint texel = texelOfInvocation();
    if (texel >= field.count || !isValid(field, texel)) return;
    ClampedTexel clamped = withoutOutlier(field, texel);
    field.clamped.at[texel] = stored(clamped.light);
    vec3 direct = field.estimates.at[texel].direct;
    field.moments.at[texel] = scaledMoment(field.moments.at[texel], direct, clamped);
}
