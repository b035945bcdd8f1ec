// What pipelines that trace batches of rays have in common.
#ifndef HALFLIGHT_BAKE_TRACE_GLSL
#define HALFLIGHT_BAKE_TRACE_GLSL

#include "payloads.glsl"
#include "scene.glsl"

layout(buffer_reference, scalar) buffer Ints { int at[]; };

layout(push_constant, scalar) uniform Push
{
    SceneData scene;
    Rays rays;
    uvec2 results;
    uint byChance; // transmittance: blended surfaces stop rays by chance
} push;

#endif
