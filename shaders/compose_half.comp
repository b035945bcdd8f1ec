#version 460
#extension GL_GOOGLE_include_directive : require
// The compose pass into half floats, on devices without such a view of RGB9E5.
#include "compose.glsl"

layout(rgba16f, set = 0, binding = kBindComposedPages) writeonly uniform image2DArray composedPages;

void storeLight(ivec3 at, vec3 irradiance)
{
    imageStore(composedPages, at, vec4(irradiance, 1.0));
}
