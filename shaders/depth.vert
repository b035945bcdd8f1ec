#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_nonuniform_qualifier : require
// Vertices of the depth pass and of shadow maps.
#include "bindings.glsl"

layout(location = 0) in vec3 inPosition;
layout(location = 1) in vec2 inUv0;
layout(location = 2) in vec2 inUv1;
layout(location = 3) in vec4 inColor;

invariant gl_Position;
layout(location = 0) out vec4 outUv;
layout(location = 1) out float outAlpha;
layout(location = 2) flat out uint outObject;

void main()
{
    outObject = instanceObjects[gl_InstanceIndex];
    vec4 position = objects[outObject].worldFromObject * vec4(inPosition, 1.0);
    gl_Position = push.clipFromWorld * position;
    outUv = vec4(inUv0, inUv1);
    outAlpha = inColor.a;
}
