// What the three pipelines that trace rays have in common.
#ifndef HALFLIGHT_BAKE_TRACE_GLSL
#define HALFLIGHT_BAKE_TRACE_GLSL

#include "scene.glsl"

layout(buffer_reference, scalar) buffer Ints { int at[]; };

layout(push_constant, scalar) uniform Push
{
    SceneData scene;
    Rays rays;
    uvec2 results;
    uint byChance; // transmittance: blended surfaces stop rays by chance
} push;




struct NearestPayload
{
    uint face;
    vec2 barycentric;
    float distance;
};
// Before the ray is traced `face` says which surfaces it meets.
const uint kAllFaces = 0u;
const uint kNoHiddenBacks = 1u;

struct ThroughPayload
{
    uint depth;  // -log2 of what passes, in units of 2^-16: integers add up in any order
    uint passed; // 1: nothing stopped the ray
};

struct SolidsPayload
{
    int left; // solids left minus entered
};

#endif
