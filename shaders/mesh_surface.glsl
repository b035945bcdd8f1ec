// A fragment of a mesh: its interpolated vertices and its material. Included by fragment shaders that mesh.vert feeds.
#ifndef HALFLIGHT_MESH_SURFACE_GLSL
#define HALFLIGHT_MESH_SURFACE_GLSL

#include "gbuffer.glsl"
#include "material.glsl"
#include "probes.glsl"
#include "surface.glsl"
#include "halflight/shading/brdf.h"
#include "halflight/shading/directional.h"
#include "halflight/shading/mask.h"

layout(location = 0) in vec3 inPosition;
layout(location = 1) in vec3 inNormal;
layout(location = 2) in vec4 inTangent;
layout(location = 3) in vec4 inUv;
layout(location = 4) in vec2 inLightmapUv;
layout(location = 5) in vec4 inColor;
layout(location = 6) flat in uint inObject;

// The fragment, and what only meshes know: what else it shines with besides direct light.
struct MeshSurface {
    Surface lit;
    vec3 vertexNormal; // interpolated: what the lightmap was baked with
    float alpha;
    float occlusion;
    vec3 emissive;
    bool unlit;
    ProbeSample probes; // what surrounds it; in realtime mode the open sky; nothing where there is a lightmap
};

vec4 readMaskLayer(vec2 uv, int page, int layer, float footprint)
{
    vec4 stored = textureLod(shadowmasks, vec3(uv, page * frame.baked.w + layer), 0.0);
    vec4 attenuation;
    for (int c = 0; c < 4; ++c)
        attenuation[c] = decodeMask(stored[c], frame.maskRange[layer][c], frame.maskPenumbra[layer][c], footprint);
    return attenuation;
}

// B by channel from the shadowmask. A pixel's width on the page is the longer of its sides there. Columns have constant
// numbers, which keeps the matrix in registers.
mat4 readShadowmask(vec2 uv, int page)
{
    vec2 size = vec2(textureSize(shadowmasks, 0).xy);
    float footprint = max(length(dFdx(uv) * size), length(dFdy(uv) * size));
    mat4 attenuation = mat4(vec4(1.0), vec4(1.0), vec4(1.0), vec4(1.0));
    attenuation[0] = readMaskLayer(uv, page, 0, footprint);
    if (kMaskLayers > 1) attenuation[1] = readMaskLayer(uv, page, 1, footprint);
    if (kMaskLayers > 2) attenuation[2] = readMaskLayer(uv, page, 2, footprint);
    if (kMaskLayers > 2 && frame.baked.w > 3) attenuation[3] = readMaskLayer(uv, page, 3, footprint);
    return attenuation;
}

MeshSurface readSurface()
{
    MeshSurface mesh;
    Surface s;
    placeSurface(s, gl_FragCoord.z);

    int material = push.info.x;
    vec4 base = materials[material].baseColor * inColor *
                materialTexture(material, kTextureBaseColor, inUv, vec4(1.0));
    s.baseColor = base.rgb;
    mesh.alpha = base.a;
    vec4 metallicRoughness = materialTexture(material, kTextureMetallicRoughness, inUv, vec4(1.0));
    s.roughness = saturate(materials[material].parameters.x * metallicRoughness.g);
    s.specular = materials[material].reflection.x;
    s.metallic = saturate(materials[material].emissiveMetallic.a * metallicRoughness.b);
    if (frame.baked.z != 0 && materials[material].info.x == 0) {
        s.baseColor = transportAlbedo(s.baseColor, s.metallic, s.roughness);
        s.metallic = 0.0;
        s.specular = 0.0;
    }
    float occlusion = materialTexture(material, kTextureOcclusion, inUv, vec4(1.0)).r;
    mesh.occlusion = 1.0 + materials[material].parameters.z * (occlusion - 1.0);
    mesh.emissive = materials[material].emissiveMetallic.rgb *
                    materialTexture(material, kTextureEmissive, inUv, vec4(1.0)).rgb;

    // Back faces of double-sided surfaces turn their whole tangent frame around, normal map included. A normal of no
    // length (a degenerate vertex) gives way to the triangle's.
    float side = gl_FrontFacing ? 1.0 : -1.0;
    vec3 face = cross(dFdx(inPosition), dFdy(inPosition));
    face = dot(face, face) > 0.0 ? normalize(face) : s.view;
    // As the G-buffer holds it, in the forward path too: what meets the shadow maps is the same.
    s.faceNormal = unpackNormal(packNormal(dot(face, s.view) < 0.0 ? -face : face));
    mesh.vertexNormal = dot(inNormal, inNormal) > 0.0 ? side * normalize(inNormal) : s.faceNormal;
    s.normal = mesh.vertexNormal;
    if (materials[material].textures[kTextureNormal].info.x >= 0 && dot(inTangent.xyz, inTangent.xyz) > 0.0) {
        vec3 n = side * mesh.vertexNormal;
        vec3 t = inTangent.xyz - n * dot(n, inTangent.xyz);
        t = dot(t, t) > 0.0 ? normalize(t) : vec3(0.0);
        vec3 b = cross(n, t) * (inTangent.w < 0.0 ? -1.0 : 1.0);
        vec3 m = materialTexture(material, kTextureNormal, inUv, vec4(0.5, 0.5, 1.0, 1.0)).xyz * 2.0 - 1.0;
        m.xy *= materials[material].parameters.y;
        vec3 mapped = t * m.x + b * m.y + n * m.z;
        if (dot(mapped, mapped) > 0.0) s.normal = side * normalize(mapped);
    }

    ivec4 info = objects[inObject].info;
    s.lightmapped = (info.x & kObjectLightmapped) != 0;
    s.receiveShadows = (info.x & kObjectReceiveShadows) != 0 && materials[material].info.y != 0;
    mat4 mask = mat4(vec4(1.0), vec4(1.0), vec4(1.0), vec4(1.0));
    if (kMaskLayers > 0) mask = readShadowmask(inLightmapUv, info.y); // derivatives want uniform control flow
    if (frame.mode.x == kModeRealtime && frame.mode.y == kViewLit)
        mesh.probes = openSky();
    else if (!s.lightmapped || frame.mode.y != kViewLit)
        mesh.probes = sampleProbes(inObject, inPosition);
    s.baked = s.lightmapped ? mask : mesh.probes.occlusion;
    mesh.unlit = materials[material].info.x != 0;
    mesh.lit = s;
    return mesh;
}

// S32. Factor from the lightmap's irradiance, which is that on the vertex normal, to another normal's. Lightmaps know the
// surface's upper side only, and give the lower one the same light: its normals are turned over.
float lightmapScale(MeshSurface mesh, vec3 normal)
{
    if (frame.baked.x == 0) return 1.0;
    float side = gl_FrontFacing ? 1.0 : -1.0;
    vec4 direction = textureLod(lightmapDirections, vec3(inLightmapUv, objects[inObject].info.y), 0.0);
    return directionalIrradianceScale(decodeMeanDirection(direction.rgb), side * mesh.vertexNormal, side * normal);
}

// S32. The same for the radiance, times pi, that the specular lobe meets.
float lightmapSpecularScale(MeshSurface mesh, vec3 lobe)
{
    if (frame.baked.x == 0) return 1.0;
    float side = gl_FrontFacing ? 1.0 : -1.0;
    vec4 direction = textureLod(lightmapDirections, vec3(inLightmapUv, objects[inObject].info.y), 0.0);
    return directionalSpecularScale(decodeMeanDirection(direction.rgb), side * mesh.vertexNormal, side * mesh.lit.normal,
                                    side * mesh.lit.view, side * lobe, mesh.lit.roughness);
}

// How far reflection probes serve this place better than the lightmap's own directions.
float reflectionTrust(MeshSurface mesh)
{
    if (frame.baked.x == 0) return 1.0;
    return textureLod(lightmapDirections, vec3(inLightmapUv, objects[inObject].info.y), 0.0).a;
}

// In lux, whatever unit the file's texels are in.
vec3 lightmapIrradiance()
{
    return textureLod(lightmaps, vec3(inLightmapUv, objects[inObject].info.y), 0.0).rgb * frame.subtractiveShadowColor.w;
}

// S32. Irradiance that the application adds to the lightmap's, in lux: Renderer::setDynamicLightmaps().
vec3 dynamicIrradiance()
{
    if (frame.baked.y == 0) return vec3(0.0);
    return textureLod(dynamicLightmaps, vec3(inLightmapUv, objects[inObject].info.y), 0.0).rgb * frame.dynamicLightmap.x;
}

#endif
