#include "transport/trace/materials.h"

#include "scene/model/tint.h"
#include "shading/srgb_table.h"
#include "transport/trace/texture_filter.h"

#include "halflight/base/parallel.h"
#include "halflight/shading/brdf.h"
#include "halflight/shading/color.h"
#include "halflight/shading/coverage.h"

#include <algorithm>

namespace halflight {
namespace {

constexpr int kSmallTextureSide = 256; ///< texels: 256 KiB a texture, so that some fit the cache

vec3 linearOf(u8vec4 texel)
{
    return {shading::kLinearFromSrgb8[texel.x], shading::kLinearFromSrgb8[texel.y], shading::kLinearFromSrgb8[texel.z]};
}

/// Averages blocks of texels in linear light. Data textures are averaged through the sRGB curve too: their means of
/// metallic and roughness are slightly off, single texels are exact.
ImageRgba8 shrink(const ImageRgba8& image)
{
    const int factor =
        std::max(1, (std::max(image.width(), image.height()) + kSmallTextureSide - 1) / kSmallTextureSide);
    if (factor == 1) return image;
    ImageRgba8 out(std::max(1, image.width() / factor), std::max(1, image.height() / factor));
    for (int y = 0; y < out.height(); ++y) {
        const int endY = std::min((y + 1) * factor, image.height());
        for (int x = 0; x < out.width(); ++x) {
            const int beginX = x * factor;
            const int endX = std::min(beginX + factor, image.width());
            vec3 sum(0.0f);
            int alpha = 0;
            for (int py = y * factor; py < endY; ++py) {
                const u8vec4* row = &image(beginX, py);
                for (int i = 0; i < endX - beginX; ++i) {
                    sum += linearOf(row[i]);
                    alpha += row[i].w;
                }
            }
            const int count = (endY - y * factor) * (endX - beginX);
            const vec3 mean = shading::srgbFromLinear(sum / float(count)) * 255.0f + 0.5f;
            out(x, y) = u8vec4(u8vec4::value_type(mean.x), u8vec4::value_type(mean.y), u8vec4::value_type(mean.z),
                               u8vec4::value_type(float(alpha) / float(count) + 0.5f));
        }
    }
    return out;
}

float bilinearAlpha(const Texture& texture, vec2 uv)
{
    return texelQuad(texture, uv).filtered([](u8vec4 texel) { return float(texel.w); }) / 255.0f;
}

TransportMaterial transportMaterial(const Scene& scene, const Material& m)
{
    // A texture that was not decoded is ignored.
    const auto usable = [&](TextureRef ref) {
        if (ref && scene.textures[std::size_t(ref.texture)].pixels.empty()) ref.texture = -1;
        return ref;
    };
    TransportMaterial t;
    t.baseColor = usable(m.baseColorTexture);
    t.metallicRoughness = usable(m.metallicRoughnessTexture);
    t.emissive = usable(m.emissiveTexture);
    // Unlit surfaces carry light on like diffuse surfaces of their colour.
    t.metallicFactor = m.unlit ? 0.0f : m.metallic;
    t.roughnessFactor = m.roughness;
    t.specular = m.specular;
    t.baseColorFactor = vec3(m.baseColor);
    t.opacity = m.baseColor.w;
    t.emission = m.emissiveNits;
    t.source = &m;
    t.opaque = m.isOpaque();
    t.blended = m.isBlended();
    t.transmission = usable(m.transmissionTexture);
    t.thickness = usable(m.thicknessTexture);
    t.attenuation = attenuationOf(m);
    t.doubleSided = m.doubleSided;
    t.unlit = m.unlit;
    return t;
}

} // namespace

Materials::Materials(const Scene& scene, const BakeGeometry& geometry) : scene_(scene), geometry_(geometry)
{
    for (const Material& material : scene.materials) materials_.push_back(transportMaterial(scene, material));
    materials_.push_back(transportMaterial(scene, defaultMaterial()));
    findTints();
    std::vector<uint8_t> used(scene.textures.size(), 0);
    for (const TransportMaterial& m : materials_) {
        for (const TextureRef& ref : {m.baseColor, m.emissive, m.metallicRoughness}) {
            if (ref) used[std::size_t(ref.texture)] = 1;
        }
    }
    smallTextures_.resize(scene.textures.size());
    parallelFor(scene.textures.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            if (used[i] != 0) smallTextures_[i] = shrink(scene.textures[i].pixels);
        }
    });
}

/// Finds the materials whose glass has a colour: by factor, texture or vertices, or by its volume.
void Materials::findTints()
{
    for (TransportMaterial& m : materials_) m.tints = tintsLight(*m.source);
    if (geometry_.colors.empty()) return;
    for (const BakeGeometry::Part& part : geometry_.parts) {
        TransportMaterial& m = part.material < 0 ? materials_.back() : materials_[std::size_t(part.material)];
        if (m.tints || !passesBaseColor(*m.source)) continue;
        const auto first = geometry_.colors.begin() + std::ptrdiff_t(part.firstVertex);
        m.tints = std::any_of(first, first + std::ptrdiff_t(part.vertexCount),
                              [](const vec4& color) { return vec3(color) != vec3(1.0f); });
    }
}

const TransportMaterial& Materials::of(uint32_t triangle) const
{
    if (triangle >= geometry_.triangleCount()) return materials_.back();
    const int material = geometry_.partOf(triangle).material;
    return material < 0 ? materials_.back() : materials_[std::size_t(material)];
}

vec2 Materials::textureCoordinate(uint32_t triangle, vec2 barycentric, const TextureRef& ref) const
{
    const uvec3 t = geometry_.verticesOf(triangle);
    const std::vector<vec2>& uv = geometry_.uv[std::size_t(ref.texCoord)];
    if (uv.empty()) return ref.offset;
    const vec2 raw =
        (1.0f - barycentric.x - barycentric.y) * uv[t.x] + barycentric.x * uv[t.y] + barycentric.y * uv[t.z];
    if (ref.rotationRadians == 0.0f) return ref.offset + raw * ref.scale;
    const vec2 turn(math::cos(ref.rotationRadians), math::sin(ref.rotationRadians));
    return shading::transformedCoordinate(raw, ref.offset, ref.scale, turn);
}

vec4 Materials::vertexColor(uint32_t triangle, vec2 barycentric) const
{
    if (geometry_.colors.empty()) return vec4(1.0f);
    const uvec3 t = geometry_.verticesOf(triangle);
    return (1.0f - barycentric.x - barycentric.y) * geometry_.colors[t.x] + barycentric.x * geometry_.colors[t.y] +
           barycentric.y * geometry_.colors[t.z];
}

float Materials::alphaAt(uint32_t triangle, vec2 barycentric, const TransportMaterial& material) const
{
    float alpha = material.opacity;
    if (material.baseColor) {
        alpha *= bilinearAlpha(scene_.textures[std::size_t(material.baseColor.texture)],
                               textureCoordinate(triangle, barycentric, material.baseColor));
    }
    if (!geometry_.colors.empty()) alpha *= vertexColor(triangle, barycentric).w;
    return alpha;
}

float Materials::coverageAt(uint32_t triangle, vec2 barycentric) const
{
    const TransportMaterial& material = of(triangle);
    if (material.opaque) return 1.0f;
    const float alpha = alphaAt(triangle, barycentric, material);
    if (material.source->transmission <= 0.0f) return material.source->coverage(alpha, 0.0f, 0.0f);
    const float metallic = material.metallicFactor * dataAt(triangle, barycentric, material.metallicRoughness).z;
    return material.source->coverage(alpha, metallic, dataAt(triangle, barycentric, material.transmission).x);
}

Materials::Glass Materials::glassAt(uint32_t triangle, vec2 barycentric, vec3 direction) const
{
    const TransportMaterial& material = of(triangle);
    vec4 color(material.baseColorFactor, alphaAt(triangle, barycentric, material));
    if (material.baseColor) {
        const Texture& texture = scene_.textures[std::size_t(material.baseColor.texture)];
        color *= vec4(
            texelQuad(texture, textureCoordinate(triangle, barycentric, material.baseColor)).filtered(linearOf), 1.0f);
    }
    if (!geometry_.colors.empty()) color *= vec4(vec3(vertexColor(triangle, barycentric)), 1.0f);
    const bool solid = material.attenuation != vec3(0.0f) && geometry_.isSolid(triangle);
    const bool thin = material.attenuation != vec3(0.0f) && !solid;
    const vec3 behind = thin ? thicknessLeaves(triangle, barycentric, direction) : vec3(1.0f);
    const float metallic = material.metallicFactor * dataAt(triangle, barycentric, material.metallicRoughness).z;
    const float texel = dataAt(triangle, barycentric, material.transmission).x;
    Glass glass;
    glass.coverage = material.source->coverage(color.w, metallic, texel);
    glass.passed = material.source->passed(color, metallic, texel, behind);
    if (solid) glass.attenuation = material.attenuation;
    return glass;
}

/// The transpose of world from object, times a triangle's normal.
vec3 Materials::thicknessAlong(uint32_t triangle) const
{
    const int object = geometry_.partOf(triangle).object;
    const mat3 worldFromObject(object < 0 ? mat4(1.0f) : scene_.objects[std::size_t(object)].worldFromObject);
    return glm::transpose(worldFromObject) * geometry_.geometricNormal(triangle);
}

/// Share of light that the thickness behind a surface of no solid leaves, on a straight way.
vec3 Materials::thicknessLeaves(uint32_t triangle, vec2 barycentric, vec3 direction) const
{
    const TransportMaterial& material = of(triangle);
    const vec3 normal = geometry_.geometricNormal(triangle);
    const float thickness = material.source->thickness * dataAt(triangle, barycentric, material.thickness).y;
    return shading::volumeLeaves(material.attenuation,
                                 shading::wayThroughPane(thickness, normal, thicknessAlong(triangle), direction));
}

/// Of a texture at full resolution, filtered; 1 where there is none.
vec4 Materials::dataAt(uint32_t triangle, vec2 barycentric, const TextureRef& ref) const
{
    if (!ref) return vec4(1.0f);
    return texelQuad(scene_.textures[std::size_t(ref.texture)], textureCoordinate(triangle, barycentric, ref))
        .filtered([](u8vec4 texel) { return vec4(texel) / 255.0f; });
}

u8vec4 Materials::smallTexel(uint32_t triangle, vec2 barycentric, const TextureRef& ref) const
{
    const auto index = std::size_t(ref.texture);
    return nearestTexel(scene_.textures[index], smallTextures_[index], textureCoordinate(triangle, barycentric, ref));
}

vec3 Materials::emissionAt(uint32_t triangle, vec2 barycentric) const
{
    const TransportMaterial& material = of(triangle);
    vec3 emission = material.emission;
    if (material.emissive && emission != vec3(0.0f)) {
        emission *= linearOf(smallTexel(triangle, barycentric, material.emissive));
    }
    return emission;
}

SurfaceReflectance Materials::reflectanceAt(uint32_t triangle, vec2 barycentric) const
{
    const TransportMaterial& material = of(triangle);
    vec3 base = material.baseColorFactor;
    if (material.baseColor) {
        base *= linearOf(smallTexel(triangle, barycentric, material.baseColor));
    }
    if (!geometry_.colors.empty()) base *= vec3(vertexColor(triangle, barycentric));
    float metallic = material.metallicFactor;
    float roughness = material.roughnessFactor;
    if (material.metallicRoughness) {
        const u8vec4 texel = smallTexel(triangle, barycentric, material.metallicRoughness);
        metallic *= float(texel.z) / 255.0f;
        roughness *= float(texel.y) / 255.0f;
    }
    return {glm::clamp(base, 0.0f, 1.0f), metallic, roughness, material.specular};
}

} // namespace halflight
