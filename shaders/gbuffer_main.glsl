// The deferred path's first pass, with or without the fifth target (HALFLIGHT_MASK_TARGET): what the light pass must know
// of a surface, and all its light but the direct one.
#include "gbuffer.glsl"
#include "indirect.glsl"

layout(location = 0) out vec4 outBaseColor;
layout(location = 1) out uvec2 outNormals;
layout(location = 2) out uvec4 outMaterial;
layout(location = 3) out vec4 outRadiance;
#ifdef HALFLIGHT_MASK_TARGET
layout(location = 4) out uvec4 outMask;
#endif

void main()
{
    MeshSurface mesh = readSurface();
    Surface s = mesh.lit;
    uint flags = (mesh.unlit ? 0u : kGBufferLit) | (s.lightmapped ? kGBufferLightmapped : 0u) |
                 (s.receiveShadows ? kGBufferReceiveShadows : 0u);
    int mainLight = frame.mode.z;
    outBaseColor = vec4(s.baseColor, mainLight >= 0 ? s.baked[lights[mainLight].info.z] : 1.0);
    outNormals = uvec2(packNormal(s.normal), packNormal(s.faceNormal));
    outMaterial = uvec4(pack16(vec4(s.metallic, s.roughness, s.specular, 0.0)).rgb, flags);
    // Lightmaps as they are: where subtractive's main light throws shadows on them, objects are drawn forward.
    outRadiance = vec4(mesh.unlit ? s.baseColor : mesh.emissive + indirectLight(mesh, lightmapIrradiance()), 1.0);
#ifdef HALFLIGHT_MASK_TARGET
    outMask = pack16(s.baked);
#endif
}
