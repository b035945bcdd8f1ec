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
    if (texel >= field.count) return;
    if (!isValid(field, texel)) {
        push.gatheredOut.at[texel] = vec4(0.0); // it had differences
        return;
    }
    ClampedTexel clamped = withoutOutlier(field, texel);
    push.gatheredOut.at[texel] = stored(clamped.light);
    if (push.directions == 0u) return;
    vec3 direct = push.hasDirect != 0u ? push.directIn.at[texel].xyz : vec3(0.0);
    push.momentsOut.at[texel] = scaledMoment(push.momentsIn.at[texel], direct, clamped);
}
