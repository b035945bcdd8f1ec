#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_nonuniform_qualifier : require
// Vertices of the lit pass.
#include "bindings.glsl"

layout(location = 0) in vec3 inPosition;
layout(location = 1) in vec2 inUv0;
layout(location = 2) in vec2 inUv1;
layout(location = 3) in vec4 inColor;
layout(location = 4) in vec3 inNormal;
layout(location = 5) in vec4 inTangent;
layout(location = 6) in vec2 inLightmapUv;

invariant gl_Position; // equal to the depth pass's, bit by bit
layout(location = 0) out vec3 outPosition;
layout(location = 1) out vec3 outNormal;
layout(location = 2) out vec4 outTangent;
layout(location = 3) out vec4 outUv; // xy set 0, zw set 1
layout(location = 4) out vec2 outLightmapUv;
layout(location = 5) out vec4 outColor;
layout(location = 6) flat out uint outObject;

void main()
{
    outObject = instanceObjects[gl_InstanceIndex];
    mat4 worldFromObject = objects[outObject].worldFromObject;
    vec4 position = worldFromObject * vec4(inPosition, 1.0);
    gl_Position = push.clipFromWorld * position;
    outPosition = position.xyz;
    vec4 n0 = objects[outObject].normalFromObject[0];
    mat3 normalFromObject =
        mat3(n0.xyz, objects[outObject].normalFromObject[1].xyz, objects[outObject].normalFromObject[2].xyz);
    outNormal = normalFromObject * inNormal;
    outTangent = vec4(mat3(worldFromObject) * inTangent.xyz, inTangent.w * n0.w);
    outUv = vec4(inUv0, inUv1);
    vec4 scaleOffset = objects[outObject].lightmapScaleOffset;
    outLightmapUv = inLightmapUv * scaleOffset.xy + scaleOffset.zw;
    outColor = inColor;
}
