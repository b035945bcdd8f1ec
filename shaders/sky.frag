#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_nonuniform_qualifier : require
// The sky where nothing was drawn. Its alpha of 0 says so (src/render/passes/samples.h).
#include "sky.glsl"

layout(location = 0) out vec4 outRadiance;

void main()
{
    vec3 direction = frame.cameraForward.xyz;
    vec2 ndc = gl_FragCoord.xy / frame.pictureSize.xy * 2.0 - 1.0;
    if (frame.cameraForward.w < 0.5) direction += ndc.x * frame.cameraRight.xyz - ndc.y * frame.cameraUp.xyz;
    direction = normalize(direction);
    // The level whose texels are as large as pixels.
    float pixel = max(length(dFdx(direction)), length(dFdy(direction)));
    float level = log2(max(pixel * frame.skyPicture.z / (2.0 * kShadingPi), 1.0));
    vec3 radiance = skyTowards(direction, level);
    outRadiance = vec4(frame.mode.y == 0 ? radiance : vec3(0.0), 0.0);
}
