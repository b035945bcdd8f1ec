// The surface where a path's ray ends: RayTracer::surfaceAt(), Materials and TriangleFrame.
#ifndef HALFLIGHT_BAKE_PATH_SURFACE_GLSL
#define HALFLIGHT_BAKE_PATH_SURFACE_GLSL

#include "tables.glsl"

#include "halflight/shading/brdf.h"

struct PathSurface {
    GpuPathFace face;
    GpuPathPart part;
    bool back;
    vec3 weights; // of the corners
    vec3 position;
    vec3 normal; // normals face the ray's origin
    vec3 geometricNormal;
    vec3 baseColor;
    float metallic;
    float roughness;
    float specular;
    vec3 emission;
};

uvec3 verticesOf(GpuPathFace face, GpuPathPart part)
{
    return cornersOf(paths().surfaces, face.stored, part.instance);
}
vec3 positionInWorld(GpuPathPart part, uint vertex)
{
    return positionOf(paths().surfaces, part.instance, vertex);
}
vec3 normalInWorld(GpuPathPart part, uint vertex)
{
    return normalOf(paths().surfaces, part.instance, vertex);
}

// Materials::smallTexel(): four bytes.
uint texelOf(GpuTextureUse use, uvec3 vertices, vec3 weights)
{
    vec2 uv = use.offset;
    if (use.set != kNone) {
        Pairs set = paths().uv[use.set];
        uv = weights.x * set.at[vertices.x] + weights.y * set.at[vertices.y] + weights.z * set.at[vertices.z];
        uv = transformedCoordinate(uv, use.offset, use.scale, use.turn);
    }
    GpuBytes picture = paths().pictures.at[use.picture];
    ivec2 at = texelPlace(uv, picture.size, picture.wrapU, picture.wrapV, true).low;
    return paths().texels.at[picture.first + uint(at.y * picture.size.x + at.x)];
}

vec3 linearOf(uint texel)
{
    Floats linear = paths().linear;
    return vec3(linear.at[texel & 0xffu], linear.at[texel >> 8u & 0xffu], linear.at[texel >> 16u & 0xffu]);
}

void addMaterial(inout PathSurface s, uvec3 vertices)
{
    GpuPathMaterial m = paths().materials.at[s.part.material];
    vec3 base = m.baseColor;
    if (m.baseColorTexture.picture >= 0) base *= linearOf(texelOf(m.baseColorTexture, vertices, s.weights));
    if (paths().all.coloredVertices != 0u) {
        Colors colors = paths().colors;
        base *= (s.weights.x * colors.at[vertices.x] + s.weights.y * colors.at[vertices.y] +
                 s.weights.z * colors.at[vertices.z]).xyz;
    }
    s.baseColor = clamp(base, vec3(0.0), vec3(1.0));
    s.metallic = m.metallic;
    s.roughness = m.roughness;
    s.specular = m.specular;
    if (m.metallicRoughnessTexture.picture >= 0) {
        uint texel = texelOf(m.metallicRoughnessTexture, vertices, s.weights);
        s.metallic *= float(texel >> 16u & 0xffu) / 255.0;
        s.roughness *= float(texel >> 8u & 0xffu) / 255.0;
    }
    s.emission = s.back && (s.face.part & kHiddenBack) != 0u ? vec3(0.0) : m.emission;
    if (m.emissiveTexture.picture >= 0 && s.emission != vec3(0.0))
        s.emission *= linearOf(texelOf(m.emissiveTexture, vertices, s.weights));
}

PathSurface surfaceAt(uint hitFace, vec2 barycentric)
{
    PathSurface s;
    uint hitIndex = hitFace & ~kBackBit;
    s.back = (hitFace & kBackBit) != 0u;
    s.face = paths().faces.at[hitIndex];
    s.part = paths().parts.at[s.face.part & ~kHiddenBack];
    s.weights = vec3(1.0 - barycentric.x - barycentric.y, barycentric);
    uvec3 v = verticesOf(s.face, s.part);
    vec3 n0 = normalInWorld(s.part, v.x);
    vec3 n1 = normalInWorld(s.part, v.y);
    vec3 n2 = normalInWorld(s.part, v.z);
    bool flat_ = n0 == n1 && n0 == n2;
    vec3 sum = flat_ ? n0 : s.weights.x * n0 + s.weights.y * n1 + s.weights.z * n2;
    s.position = s.weights.x * positionInWorld(s.part, v.x) + s.weights.y * positionInWorld(s.part, v.y) +
                 s.weights.z * positionInWorld(s.part, v.z);
    s.geometricNormal = push.tables.normals.at[hitIndex];
    s.normal = shadingNormalOf(sum, s.geometricNormal);
    if (s.back) {
        s.normal = -s.normal;
        s.geometricNormal = -s.geometricNormal;
    }
    addMaterial(s, v);
    return s;
}

// RayScene::epsilonAt() and rayOrigin().
float epsilonAt(PathSurface s)
{
    return rayEpsilon(s.position, push.tables.scene.scale);
}
vec3 rayOriginOf(PathSurface s)
{
    return s.position + s.geometricNormal * epsilonAt(s);
}

// PathTracer::albedoOf().
vec3 albedoOf(PathSurface s)
{
    if (paths().all.glossy == 0u) return transportAlbedo(s.baseColor, s.metallic, s.roughness);
    return diffuseAlbedoOf(s.baseColor, s.metallic) *
           averageDiffuseShare(specularF0Of(s.baseColor, s.metallic, s.specular), specularF90Of(s.metallic, s.specular));
}

#endif
