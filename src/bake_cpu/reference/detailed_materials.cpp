#include "bake_cpu/reference/detailed_materials.h"

#include "shading/srgb_table.h"
#include "transport/trace/texture_filter.h"

namespace halflight {
namespace {

vec3 linearFromSrgb(u8vec4 texel)
{
    return {shading::kLinearFromSrgb8[texel.x], shading::kLinearFromSrgb8[texel.y], shading::kLinearFromSrgb8[texel.z]};
}

vec3 dataOf(u8vec4 texel)
{
    return vec3(texel) / 255.0f;
}

} // namespace

DetailedMaterials::DetailedMaterials(const Scene& scene, const RayTracer& surfaces) : scene_(scene), surfaces_(surfaces)
{
    for (const BakeGeometry::Part& part : surfaces.geometry().parts) {
        const mat3 linear(scene.objects[std::size_t(part.object)].worldFromObject);
        mirrored_.push_back(glm::determinant(linear) < 0.0f ? -1.0f : 1.0f);
    }
}

const Material& DetailedMaterials::of(uint32_t triangle) const
{
    const BakeGeometry& geometry = surfaces_.geometry();
    const int material = geometry.partOf(triangle).material;
    return material < 0 ? defaultMaterial() : scene_.materials[std::size_t(material)];
}

/// Null for textures that were not decoded, which are ignored.
const Texture* DetailedMaterials::textureOf(const TextureRef& ref) const
{
    if (!ref) return nullptr;
    const Texture& texture = scene_.textures[std::size_t(ref.texture)];
    return texture.pixels.empty() ? nullptr : &texture;
}

SurfaceReflectance DetailedMaterials::reflectanceAt(uint32_t triangle, vec2 barycentric) const
{
    const Material& material = of(triangle);
    const Materials& coarse = surfaces_.materials();
    SurfaceReflectance r{vec3(material.baseColor) * vec3(coarse.vertexColor(triangle, barycentric)), material.metallic,
                         material.roughness, material.specular};
    if (const Texture* texture = textureOf(material.baseColorTexture)) {
        const vec2 uv = coarse.textureCoordinate(triangle, barycentric, material.baseColorTexture);
        r.baseColor *= texelQuad(*texture, uv).filtered(linearFromSrgb);
    }
    if (const Texture* texture = textureOf(material.metallicRoughnessTexture)) {
        const vec2 uv = coarse.textureCoordinate(triangle, barycentric, material.metallicRoughnessTexture);
        const vec3 data = texelQuad(*texture, uv).filtered(dataOf);
        r.metallic *= data.z;
        r.roughness *= data.y;
    }
    r.baseColor = glm::clamp(r.baseColor, 0.0f, 1.0f);
    r.metallic = glm::clamp(r.metallic, 0.0f, 1.0f);
    r.roughness = glm::clamp(r.roughness, 0.0f, 1.0f);
    if (material.unlit) r.metallic = r.specular = 0.0f;
    return r;
}

vec3 DetailedMaterials::emissionAt(uint32_t triangle, vec2 barycentric) const
{
    const Material& material = of(triangle);
    if (material.emissiveNits == vec3(0.0f)) return vec3(0.0f);
    const Texture* texture = textureOf(material.emissiveTexture);
    if (texture == nullptr) return material.emissiveNits;
    const vec2 uv = surfaces_.materials().textureCoordinate(triangle, barycentric, material.emissiveTexture);
    return material.emissiveNits * texelQuad(*texture, uv).filtered(linearFromSrgb);
}

vec4 DetailedMaterials::tangentAt(uint32_t triangle, vec2 barycentric) const
{
    const BakeGeometry& geometry = surfaces_.geometry();
    const uint32_t number = geometry.partNumberOf(triangle);
    const BakeGeometry::Part& part = geometry.parts[number];
    const std::vector<vec4>& tangents = scene_.meshes[std::size_t(part.mesh)].parts[std::size_t(part.part)].tangents;
    if (tangents.empty()) return vec4(0.0f);
    const uvec3 t = geometry.verticesOf(triangle) - uvec3(part.firstVertex);
    const vec4 tangent = (1.0f - barycentric.x - barycentric.y) * tangents[t.x] + barycentric.x * tangents[t.y] +
                         barycentric.y * tangents[t.z];
    const mat3 linear(scene_.objects[std::size_t(part.object)].worldFromObject);
    return {linear * vec3(tangent), tangent.w * mirrored_[number]};
}

// The steps are those of shaders/mesh_surface.glsl: the back of a surface turns its whole tangent frame around, the map
// included.
vec3 DetailedMaterials::mappedNormal(const SurfacePoint& point, bool back) const
{
    const Material& material = of(point.triangle);
    const Texture* texture = textureOf(material.normalTexture);
    if (texture == nullptr) return point.normal;
    const vec4 tangent = tangentAt(point.triangle, point.barycentric);
    if (vec3(tangent) == vec3(0.0f)) return point.normal;
    const float side = back ? -1.0f : 1.0f;
    const vec3 n = side * point.normal;
    vec3 t = vec3(tangent) - n * glm::dot(n, vec3(tangent));
    const float length = glm::length(t);
    t = length > 0.0f ? t / length : vec3(0.0f);
    const vec3 b = glm::cross(n, t) * (tangent.w < 0.0f ? -1.0f : 1.0f);
    const vec2 uv = surfaces_.materials().textureCoordinate(point.triangle, point.barycentric, material.normalTexture);
    vec3 m = texelQuad(*texture, uv).filtered(dataOf) * 2.0f - 1.0f;
    m.x *= material.normalScale;
    m.y *= material.normalScale;
    const vec3 mapped = t * m.x + b * m.y + n * m.z;
    return mapped != vec3(0.0f) ? side * glm::normalize(mapped) : point.normal;
}

} // namespace halflight
