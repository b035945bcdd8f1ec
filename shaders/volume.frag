#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_nonuniform_qualifier : require
// S35. Optical depth of closed glass volumes along each pixel's ray: a face adds the way to where the ray leaves through
// it, or takes off the way to where it enters, in any order. A face behind what the picture shows counts as there, so
// that a ray that ends in a volume counts to its end. One that begins in a volume counts from the camera.
#include "surface.glsl"

layout(set = 0, binding = kBindDepth) uniform sampler2D depthBuffer;

layout(location = 0) in vec3 inPosition;
layout(location = 0) out vec4 outDepth;

void main()
{
    float meters = length(viewRay(inPosition));
    float depth = texelFetch(depthBuffer, ivec2(gl_FragCoord.xy), 0).r;
    if (depth > 0.0) meters = min(meters, length(viewRay(worldPosition(depth)))); // 0: the sky
    outDepth = vec4(materials[push.info.x].volume.rgb * (gl_FrontFacing ? -meters : meters), 0.0);
}
