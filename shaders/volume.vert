#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_nonuniform_qualifier : require
// Vertices of glass volumes (shaders/volume.frag).
#include "bindings.glsl"

layout(location = 0) in vec3 inPosition;

layout(location = 0) out vec3 outPosition;

void main()
{
    vec4 position = objects[instanceObjects[gl_InstanceIndex]].worldFromObject * vec4(inPosition, 1.0);
    gl_Position = push.clipFromWorld * position;
    outPosition = position.xyz;
}
