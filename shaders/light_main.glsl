// The deferred path's second pass, with or without the fifth target (HALFLIGHT_MASK_TARGET): direct light of each pixel's
// cluster, added to the picture.
#include "gbuffer.glsl"
#include "lighting.glsl"

layout(set = 0, binding = kBindGBufferBaseColor) uniform sampler2D gbufferBaseColor;
layout(set = 0, binding = kBindGBufferNormals) uniform usampler2D gbufferNormals;
layout(set = 0, binding = kBindGBufferMaterial) uniform usampler2D gbufferMaterial;
#ifdef HALFLIGHT_MASK_TARGET
layout(set = 0, binding = kBindGBufferMask) uniform sampler2D gbufferMask;
#endif
layout(set = 0, binding = kBindDepth) uniform sampler2D depthBuffer;

layout(location = 0) in vec2 inNdc;
layout(location = 0) out vec4 outRadiance;

// The point of the world that this pixel's centre shows.
vec3 worldPosition(float depth)
{
    vec4 r = frame.depthRange; // depth = (z * r.x + r.z) / (z * r.y + r.w) at view space z
    float viewDepth = (r.z - depth * r.w) / (r.x - depth * r.y);
    vec3 across = inNdc.x * frame.cameraRight.xyz - inNdc.y * frame.cameraUp.xyz;
    return frame.cameraPosition.xyz + frame.cameraForward.xyz * viewDepth +
           across * (frame.cameraForward.w > 0.5 ? 1.0 : viewDepth);
}

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    uvec4 material = texelFetch(gbufferMaterial, pixel, 0);
    if ((material.a & kGBufferLit) == 0u) discard;

    Surface s;
    placeSurface(s, worldPosition(texelFetch(depthBuffer, pixel, 0).r));
    uvec2 normals = texelFetch(gbufferNormals, pixel, 0).rg;
    s.normal = unpackNormal(normals.x);
    s.faceNormal = unpackNormal(normals.y);
    vec4 baseColor = texelFetch(gbufferBaseColor, pixel, 0);
    s.baseColor = baseColor.rgb;
    vec3 values = unpackMaterial(material.rgb);
    s.metallic = values.x;
    s.roughness = values.y;
    s.specular = values.z;
    s.lightmapped = (material.a & kGBufferLightmapped) != 0u;
    s.receiveShadows = (material.a & kGBufferReceiveShadows) != 0u;
#ifdef HALFLIGHT_MASK_TARGET
    s.baked = texelFetch(gbufferMask, pixel, 0);
#else
    s.baked = vec4(baseColor.a);
#endif
    outRadiance = vec4(directLight(s), 0.0);
}
