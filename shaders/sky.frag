#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_nonuniform_qualifier : require
// The sky where nothing was drawn.
#include "bindings.glsl"
#include "halflight/shading/sky.h"

layout(location = 0) in vec2 inNdc;
layout(location = 0) out vec4 outRadiance;

void main()
{
    vec3 direction = frame.cameraForward.xyz;
    if (frame.cameraForward.w < 0.5) direction += inNdc.x * frame.cameraRight.xyz - inNdc.y * frame.cameraUp.xyz;
    vec3 radiance = skyRadiance(frame.skyZenith.rgb, frame.skyHorizon.rgb, frame.skyGround.rgb, normalize(direction));
    outRadiance = vec4(frame.mode.y == 0 ? radiance : vec3(0.0), 1.0);
}
