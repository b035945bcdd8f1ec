// What the denoiser's shaders read, by the names that the headers of src/bake/seams and src/bake/denoise use.
#ifndef HALFLIGHT_BAKE_DENOISE_GLSL
#define HALFLIGHT_BAKE_DENOISE_GLSL

#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference2 : require
#extension GL_EXT_buffer_reference_uvec2 : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require

#include "bake_gpu/denoise_layout.h"
#include "halflight/shading/denoise.h"
#include "invocation.glsl"

layout(local_size_x = 64) in; // kDenoiseGroup

layout(buffer_reference, scalar) readonly buffer Cells { GpuCell at[]; };
layout(buffer_reference, scalar) readonly buffer Texels { GpuTexel at[]; };
layout(buffer_reference, scalar) readonly buffer Firsts { uint at[]; };
layout(buffer_reference, scalar) readonly buffer Crossings { SeamCrossing at[]; };
layout(buffer_reference, scalar) readonly buffer Guides { GpuGuide at[]; };
layout(buffer_reference, scalar) buffer Differences { SecondDifference at[]; };
layout(buffer_reference, scalar) buffer Variances { float at[]; };
layout(buffer_reference, scalar) buffer Lights { vec4 at[]; }; // NoisyLight
layout(buffer_reference, scalar) buffer Moments { vec3 at[]; };

// DeviceGrid and DeviceField in src/bake_gpu/denoise.cpp.
struct Grid {
    Cells cells;
    Texels texels;
    Firsts firsts;
    Crossings crossings;
    int pageSize;
};
struct Field {
    Grid grid;
    Guides guides;
    Differences differences;
    Variances variances; // of gathered light, calibrated
    uint count;
};
layout(buffer_reference, scalar) readonly buffer FieldData { Field field; };

// DenoisePush in src/bake_gpu/denoise.cpp: what a pass reads and writes of one component. Before outliers are removed,
// signals are as they are stated.
layout(push_constant, scalar) uniform Push
{
    FieldData data;
    Lights gatheredIn;
    Lights directIn;
    Moments momentsIn;
    Lights gatheredOut;
    Lights directOut;
    Moments momentsOut;
    uint hasDirect;
    uint directions;
    int number; // of the filter's level
}
push;

uint texelOfInvocation()
{
    return invocationOf(kDenoiseGroup);
}

ivec2 placeOfTexel(Grid grid, uint texel)
{
    uint place = grid.texels.at[texel].columnRow;
    return ivec2(int(place & 0xffffu), int(place >> 16u));
}
uint texelAt(Grid grid, uint texel, ivec2 place)
{
    int size = grid.pageSize;
    if (place.x < 0 || place.y < 0 || place.x >= size || place.y >= size) return kNowhere;
    GpuTexel from = grid.texels.at[texel];
    GpuCell cell = grid.cells.at[((from.bits >> kPageShift) * uint(size) + uint(place.y)) * uint(size) + uint(place.x)];
    return cell.chart == from.chart ? cell.texel : kNowhere;
}
bool chartHasSeams(Grid grid, uint texel)
{
    return (grid.texels.at[texel].bits & kHasSeams) != 0u;
}
uint crossingsAround(Grid grid, uint texel)
{
    return grid.texels.at[texel].bits & kCrossingBits;
}
uint firstCrossing(Grid grid, uint texel)
{
    return grid.firsts.at[texel];
}
SeamCrossing crossingAt(Grid grid, uint crossing)
{
    return grid.crossings.at[crossing];
}

NoisyLight lightOf(vec4 stored)
{
    return noisyLight(stored.xyz, stored.w);
}
vec4 stored(NoisyLight light)
{
    return vec4(light.irradiance, light.variance);
}

bool isValid(Field field, uint texel)
{
    return (field.grid.texels.at[texel].bits & kIsValid) != 0u;
}
bool isWhole(Field field, uint texel)
{
    return (field.grid.texels.at[texel].bits & kIsWhole) != 0u;
}
bool hasFewSamples(Field field, uint texel)
{
    return (field.grid.texels.at[texel].bits & kHasFewSamples) != 0u;
}
NoisyLight statedLight(Field field, uint texel)
{
    return lightOf(push.gatheredIn.at[texel]);
}
SecondDifference differenceAt(Field field, uint texel)
{
    return field.differences.at[texel];
}
NoisyLight scaledLight(Field field, uint texel)
{
    return noisyLight(push.gatheredIn.at[texel].xyz, field.variances.at[texel]);
}
#endif
