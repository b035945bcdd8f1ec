#include "bake_cpu/trace/materials.h"

#include "shading/srgb_table.h"

#include "halflight/base/parallel.h"
#include "halflight/shading/brdf.h"
#include "halflight/shading/color.h"

#include <algorithm>
#include <cmath>

namespace halflight {
namespace {

constexpr int kSmallTextureSide = 256;

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

int wrap(int i, int size, Texture::Wrap mode)
{
    if (unsigned(i) < unsigned(size)) return i;
    switch (mode) {
    case Texture::Wrap::ClampToEdge:
        return std::clamp(i, 0, size - 1);
    case Texture::Wrap::MirroredRepeat: {
        const int period = 2 * size;
        const int m = ((i % period) + period) % period;
        return m < size ? m : period - 1 - m;
    }
    default:
        return (size & (size - 1)) == 0 ? i & (size - 1) : ((i % size) + size) % size;
    }
}

/// Index of the texel at a coordinate; 0 for coordinates that are not finite.
int texelNumber(float coordinate, int size)
{
    const float t = coordinate * float(size);
    return std::isfinite(t) ? int(std::floor(std::clamp(t, -1.0e9f, 1.0e9f))) : 0;
}

u8vec4 nearestTexel(const Texture& texture, const ImageRgba8& pixels, vec2 uv)
{
    return pixels(wrap(texelNumber(uv.x, pixels.width()), pixels.width(), texture.wrapU),
                  wrap(texelNumber(uv.y, pixels.height()), pixels.height(), texture.wrapV));
}

float bilinearAlpha(const Texture& texture, vec2 uv)
{
    const ImageRgba8& pixels = texture.pixels;
    if (texture.nearest) return float(nearestTexel(texture, pixels, uv).w) / 255.0f;
    const vec2 place = uv * vec2(pixels.size()) - 0.5f;
    const int x = texelNumber(place.x / float(pixels.width()), pixels.width());
    const int y = texelNumber(place.y / float(pixels.height()), pixels.height());
    const vec2 f = glm::clamp(place - vec2(float(x), float(y)), 0.0f, 1.0f);
    const int x0 = wrap(x, pixels.width(), texture.wrapU);
    const int x1 = wrap(x + 1, pixels.width(), texture.wrapU);
    const int y0 = wrap(y, pixels.height(), texture.wrapV);
    const int y1 = wrap(y + 1, pixels.height(), texture.wrapV);
    const float top = glm::mix(float(pixels(x0, y0).w), float(pixels(x1, y0).w), f.x);
    const float bottom = glm::mix(float(pixels(x0, y1).w), float(pixels(x1, y1).w), f.x);
    return glm::mix(top, bottom, f.y) / 255.0f;
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
    t.alphaMode = m.alphaMode;
    t.alphaCutoff = m.alphaCutoff;
    t.doubleSided = m.doubleSided;
    t.unlit = m.unlit;
    return t;
}

} // namespace

Materials::Materials(const Scene& scene, const BakeGeometry& geometry) : scene_(scene), geometry_(geometry)
{
    for (const Material& material : scene.materials) materials_.push_back(transportMaterial(scene, material));
    materials_.push_back(transportMaterial(scene, defaultMaterial()));
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

const TransportMaterial& Materials::of(uint32_t triangle) const
{
    if (triangle >= geometry_.partOfTriangle.size()) return materials_.back();
    const int material = geometry_.parts[geometry_.partOfTriangle[triangle]].material;
    return material < 0 ? materials_.back() : materials_[std::size_t(material)];
}

vec2 Materials::textureCoordinate(uint32_t triangle, vec2 barycentric, const TextureRef& ref) const
{
    const uvec3 t = geometry_.triangles[triangle];
    const std::vector<vec2>& uv = geometry_.uv[ref.texCoord == 1 ? 1 : 0];
    const vec2 raw =
        (1.0f - barycentric.x - barycentric.y) * uv[t.x] + barycentric.x * uv[t.y] + barycentric.y * uv[t.z];
    // KHR_texture_transform: translation * rotation * scale.
    const vec2 scaled = raw * ref.scale;
    if (ref.rotationRadians == 0.0f) return ref.offset + scaled;
    const float c = std::cos(ref.rotationRadians);
    const float s = std::sin(ref.rotationRadians);
    return ref.offset + vec2(c * scaled.x + s * scaled.y, -s * scaled.x + c * scaled.y);
}

float Materials::alphaAt(uint32_t triangle, vec2 barycentric, const TransportMaterial& material) const
{
    float alpha = material.opacity;
    if (material.baseColor) {
        alpha *= bilinearAlpha(scene_.textures[std::size_t(material.baseColor.texture)],
                               textureCoordinate(triangle, barycentric, material.baseColor));
    }
    if (!geometry_.colors.empty()) {
        const uvec3 t = geometry_.triangles[triangle];
        alpha *= (1.0f - barycentric.x - barycentric.y) * geometry_.colors[t.x].w +
                 barycentric.x * geometry_.colors[t.y].w + barycentric.y * geometry_.colors[t.z].w;
    }
    return alpha;
}

float Materials::coverageAt(uint32_t triangle, vec2 barycentric) const
{
    const TransportMaterial& material = of(triangle);
    if (material.alphaMode == Material::AlphaMode::Opaque) return 1.0f;
    const float alpha = alphaAt(triangle, barycentric, material);
    if (material.alphaMode == Material::AlphaMode::Mask) return alpha < material.alphaCutoff ? 0.0f : 1.0f;
    return glm::clamp(alpha, 0.0f, 1.0f);
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
    if (!geometry_.colors.empty()) {
        const uvec3 t = geometry_.triangles[triangle];
        base *= vec3((1.0f - barycentric.x - barycentric.y) * geometry_.colors[t.x] +
                     barycentric.x * geometry_.colors[t.y] + barycentric.y * geometry_.colors[t.z]);
    }
    float metallic = material.metallicFactor;
    float roughness = material.roughnessFactor;
    if (material.metallicRoughness) {
        const u8vec4 texel = smallTexel(triangle, barycentric, material.metallicRoughness);
        metallic *= float(texel.z) / 255.0f;
        roughness *= float(texel.y) / 255.0f;
    }
    return {glm::clamp(base, 0.0f, 1.0f), metallic, roughness, material.specular};
}

vec3 Materials::albedoAt(uint32_t triangle, vec2 barycentric) const
{
    const SurfaceReflectance r = reflectanceAt(triangle, barycentric);
    return r.metallic > 0.0f ? shading::transportAlbedo(r.baseColor, r.metallic, r.roughness) : r.baseColor;
}

} // namespace halflight
