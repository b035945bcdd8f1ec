#version 460
#extension GL_GOOGLE_include_directive : require
#include "trace.glsl"

layout(location = 0) rayPayloadInEXT NearestPayload payload;

void main()
{
    payload.distance = -1.0;
}
