// The deferred path's second pass, with the mask layers of the first (HALFLIGHT_MASK_TARGETS): direct light of each
// pixel's cluster, added to the picture.
#include "gbuffer.glsl"
#include "lighting.glsl"

layout(set = 0, binding = kBindGBufferBaseColor) uniform sampler2D gbufferBaseColor;
layout(set = 0, binding = kBindGBufferNormals) uniform usampler2D gbufferNormals;
layout(set = 0, binding = kBindGBufferMaterial) uniform usampler2D gbufferMaterial;
#if HALFLIGHT_MASK_TARGETS > 0
layout(set = 0, binding = kBindGBufferMask) uniform usampler2D gbufferMask;
#endif
#if HALFLIGHT_MASK_TARGETS > 2
layout(set = 0, binding = kBindGBufferFurtherMask) uniform usampler2D gbufferFurtherMask;
#endif
layout(set = 0, binding = kBindDepth) uniform sampler2D depthBuffer;

layout(location = 0) out vec4 outRadiance;

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    uvec4 material = texelFetch(gbufferMaterial, pixel, 0);
    if ((material.a & kGBufferLit) == 0u) discard;

    Surface s;
    placeSurface(s, texelFetch(depthBuffer, pixel, 0).r);
    uvec2 normals = texelFetch(gbufferNormals, pixel, 0).rg;
    s.normal = unpackNormal(normals.x);
    s.faceNormal = unpackNormal(normals.y);
    vec4 baseColor = texelFetch(gbufferBaseColor, pixel, 0);
    s.baseColor = baseColor.rgb;
    vec3 values = unpack16(material).rgb;
    s.metallic = values.x;
    s.roughness = values.y;
    s.specular = values.z;
    s.lightmapped = (material.a & kGBufferLightmapped) != 0u;
    s.receiveShadows = (material.a & kGBufferReceiveShadows) != 0u;
    s.baked = mat4(vec4(baseColor.a), vec4(1.0), vec4(1.0), vec4(1.0));
#if HALFLIGHT_MASK_TARGETS > 0
    uvec4 mask = texelFetch(gbufferMask, pixel, 0);
    s.baked[0] = unpack16(mask & 0xffffu);
    s.baked[1] = unpack16(mask >> 16);
#endif
#if HALFLIGHT_MASK_TARGETS > 2
    uvec4 furtherMask = texelFetch(gbufferFurtherMask, pixel, 0);
    s.baked[2] = unpack16(furtherMask & 0xffffu);
    s.baked[3] = unpack16(furtherMask >> 16);
#endif
    outRadiance = vec4(directLight(s), 0.0);
}
