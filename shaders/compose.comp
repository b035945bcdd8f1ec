#version 460
#extension GL_GOOGLE_include_directive : require
// The compose pass into RGB9E5, whose texels a view has as numbers of 32 bits.
#include "compose.glsl"

layout(r32ui, set = 0, binding = kBindComposedPages) writeonly uniform uimage2DArray composedPages;

void storeLight(ivec3 at, vec3 irradiance)
{
    imageStore(composedPages, at, uvec4(packTexel(irradiance)));
}
