// The deferred path's first pass, with targets for so many mask layers (HALFLIGHT_MASK_TARGETS: 0, 1, 2 or 4): what the
// light pass must know of a surface, and all its light but the direct one.
#include "gbuffer.glsl"
#include "indirect.glsl"

layout(location = 0) out vec4 outBaseColor;
layout(location = 1) out uvec2 outNormals;
layout(location = 2) out uvec4 outMaterial;
layout(location = 3) out vec4 outRadiance;
#if HALFLIGHT_MASK_TARGETS > 0
layout(location = 4) out uvec4 outMask;
#endif
#if HALFLIGHT_MASK_TARGETS > 2
layout(location = 5) out uvec4 outFurtherMask;
#endif

void main()
{
    MeshSurface mesh = readSurface();
    Surface s = mesh.lit;
    uint flags = (mesh.unlit ? 0u : kGBufferLit) | (s.lightmapped ? kGBufferLightmapped : 0u) |
                 (s.receiveShadows ? kGBufferReceiveShadows : 0u);
    int mainLight = frame.mode.z;
    outBaseColor = vec4(s.baseColor, mainLight >= 0 ? bakedOfChannel(s, lights[mainLight].info.z) : 1.0);
    outNormals = uvec2(packNormal(s.normal), packNormal(s.faceNormal));
    outMaterial = uvec4(pack16(vec4(s.metallic, s.roughness, s.specular, 0.0)).rgb, flags);
    // Lightmaps as they are: where subtractive's main light throws shadows on them, objects are drawn forward.
    outRadiance = vec4(mesh.unlit ? s.baseColor : mesh.emissive + indirectLight(mesh, lightmapIrradiance()), 1.0);
#if HALFLIGHT_MASK_TARGETS == 1
    outMask = pack16(s.baked[0]);
#elif HALFLIGHT_MASK_TARGETS > 1
    outMask = packLayers(s.baked[0], s.baked[1]);
#endif
#if HALFLIGHT_MASK_TARGETS > 2
    outFurtherMask = packLayers(s.baked[2], s.baked[3]);
#endif
}
