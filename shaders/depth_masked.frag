#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_nonuniform_qualifier : require
// Alpha-masked surfaces in the depth pass and in shadow maps: their holes let light through.
#include "material.glsl"

layout(location = 0) in vec4 inUv;
layout(location = 1) in float inAlpha;

void main()
{
    int material = push.info.x;
    float alpha = materials[material].baseColor.a * inAlpha *
                  materialTexture(material, kTextureBaseColor, inUv, vec4(1.0)).a;
    if (alpha < materials[material].parameters.w) discard;
}
