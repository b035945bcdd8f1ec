#version 460
#extension GL_GOOGLE_include_directive : require
#include "trace.glsl"

layout(location = 0) rayPayloadInEXT ThroughPayload payload;

void main()
{
    payload.state = kPassed;
}
