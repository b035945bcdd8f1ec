#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_nonuniform_qualifier : require
// Alpha-masked surfaces in the depth pass and in shadow maps: their holes let light through. Blended surfaces in shadow
// maps: they cover the share of texels that their alpha says.
#include "material.glsl"
#include "hashed_alpha.glsl"

layout(constant_id = 0) const int kAlphaMode = kAlphaMask;

layout(location = 0) in vec4 inUv;
layout(location = 1) in float inAlpha;
layout(location = 2) flat in uint inObject;

void main()
{
    int material = push.info.x;
    float alpha = materials[material].baseColor.a * inAlpha *
                  materialTexture(material, kTextureBaseColor, inUv, vec4(1.0)).a;
    if (kAlphaMode == kAlphaBlend) {
        alpha = coverage(material, inUv, alpha);
        // Objects that follow one another, and the two sides of one, are different layers.
        uint layer = (inObject + 3u * uint(material) + (gl_FrontFacing ? 0u : 4u)) % uint(kAlphaLayers);
        if (alpha <= alphaThreshold(ivec2(gl_FragCoord.xy) - push.info.yz, int(layer))) discard;
    } else if (alpha < materials[material].parameters.w) {
        discard;
    }
}
