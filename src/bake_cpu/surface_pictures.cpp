#include "halflight/bake_cpu/surface_pictures.h"

#include "bake/geometry/flatten.h"
#include "bake/pages/dilate.h"
#include "bake/texels/rasterize.h"
#include "shading/srgb_table.h"
#include "transport/trace/materials.h"
#include "transport/trace/texture_filter.h"

#include "halflight/base/image_filter.h"
#include "halflight/base/mathematics.h"
#include "halflight/base/parallel.h"
#include "halflight/shading/brdf.h"
#include "halflight/shading/color.h"

#include <algorithm>
#include <array>

namespace halflight {
namespace {

constexpr float kMostStrength = 16.0f;
constexpr double kClippedShare = 0.001; // of texels above a strength that is chosen here
constexpr double kWhiteShare = 0.05;    // of texels above white at an exposure that is chosen here

float brightest(const vec4& texel)
{
    return std::max({texel.x, texel.y, texel.z});
}

/// Colours at points of triangles, of textures as fine as they are.
class SurfaceColors {
public:
    SurfaceColors(const Scene& scene, const BakeGeometry& geometry)
        : scene_(scene), geometry_(geometry), materials_(scene, geometry)
    {}

    struct Color {
        vec3 albedo{0.0f};
        vec3 emission{0.0f};
        float opacity = 1.0f;
    };
    [[nodiscard]] Color at(uint32_t triangle, vec2 barycentric) const
    {
        const int index = geometry_.partOf(triangle).material;
        const Material& m = index < 0 ? defaultMaterial() : scene_.materials[std::size_t(index)];
        const auto color = [&](const TextureRef& ref) { return texel(triangle, barycentric, ref, true); };
        const auto data = [&](const TextureRef& ref) { return texel(triangle, barycentric, ref, false); };
        vec3 base = vec3(m.baseColor) * color(m.baseColorTexture);
        if (!geometry_.colors.empty()) base *= vec3(materials_.vertexColor(triangle, barycentric));
        const vec3 metallicRoughness = data(m.metallicRoughnessTexture);
        const float occlusion = 1.0f + m.occlusionStrength * (data(m.occlusionTexture).x - 1.0f);
        const vec3 albedo = shading::transportAlbedo(glm::clamp(base, 0.0f, 1.0f), m.metallic * metallicRoughness.z,
                                                     m.roughness * metallicRoughness.y);
        return {occlusion * albedo, m.emissiveNits * color(m.emissiveTexture),
                materials_.coverageAt(triangle, barycentric)};
    }

private:
    [[nodiscard]] vec3 texel(uint32_t triangle, vec2 barycentric, const TextureRef& ref, bool isColor) const
    {
        if (!ref) return vec3(1.0f);
        const Texture& texture = scene_.textures[std::size_t(ref.texture)];
        if (texture.pixels.empty()) return vec3(1.0f);
        return texelQuad(texture, materials_.textureCoordinate(triangle, barycentric, ref)).filtered([&](u8vec4 t) {
            if (!isColor) return vec3(float(t.x), float(t.y), float(t.z)) / 255.0f;
            return vec3(shading::kLinearFromSrgb8[t.x], shading::kLinearFromSrgb8[t.y], shading::kLinearFromSrgb8[t.z]);
        });
    }

    const Scene& scene_;
    const BakeGeometry& geometry_;
    Materials materials_;
};

/// Mean over the points of a texel. Colours count by their opacity, so that what is cut out leaves no fringe.
vec4 texelRadiance(const SurfaceColors& colors, std::span<const SurfacePoint> points, vec3 irradiance)
{
    vec3 weighted(0.0f);
    vec3 sum(0.0f);
    float opacity = 0.0f;
    for (const SurfacePoint& point : points) {
        const SurfaceColors::Color color = colors.at(point.triangle, point.barycentric);
        const vec3 radiance = shading::diffuseRadiance(color.albedo, irradiance) + color.emission;
        weighted += color.opacity * radiance;
        sum += radiance;
        opacity += color.opacity;
    }
    const vec3 mean = opacity > 0.0f ? weighted / opacity : sum / float(points.size());
    return {mean, opacity / float(points.size())};
}

/// Calls visit(texel) on the texels of all pages where a surface is.
template<typename Visit> void eachTexel(const std::vector<ImageRgba32f>& pictures, const Visit& visit)
{
    for (const ImageRgba32f& page : pictures) {
        for (const vec4& texel : page.texels()) {
            if (texel != vec4(0.0f)) visit(texel);
        }
    }
}

/// The light that a share of the texels exceeds.
float lightAbove(const std::vector<ImageRgba32f>& pictures, double share)
{
    std::vector<float> values;
    eachTexel(pictures, [&](const vec4& texel) { values.push_back(brightest(texel)); });
    if (values.empty()) return 0.0f;
    const auto rank = std::ptrdiff_t(double(values.size() - 1) * (1.0 - share));
    std::nth_element(values.begin(), values.begin() + rank, values.end());
    return values[std::size_t(rank)];
}

} // namespace

Result<std::vector<ImageRgba32f>> surfacePictures(const Scene& scene, const std::vector<ImageRgb32f>& irradiance,
                                                  int scale, const Progress& progress)
{
    if (irradiance.empty()) return std::vector<ImageRgba32f>();
    BakeGeometry geometry = flattenGeometry(scene, irradiance[0].width() * scale, GeometryFilter::Static);
    for (BakeGeometry::Part& part : geometry.parts) {
        if (part.material >= 0 && scene.materials[std::size_t(part.material)].unlit) part.page = -1;
    }
    const TexelMap map = rasterizeTexels(geometry, irradiance[0].width() * scale, int(irradiance.size()));
    const SurfaceColors colors(scene, geometry);
    std::vector<vec4> values(map.texels.size());
    parallelFor(map.texels.size(), 4096, [&](std::size_t begin, std::size_t end) {
        if (progress.cancelled()) return;
        std::array<SurfacePoint, kMaxTexelPoints> points;
        for (std::size_t i = begin; i < end; ++i) {
            const Texel& texel = map.texels[i];
            const auto count = std::size_t(texelPoints(geometry, map, texel, points));
            const vec2 place = (vec2(texel.x, texel.y) + 0.5f) / float(scale);
            values[i] = texelRadiance(colors, std::span(points).first(count), bilinear(irradiance[texel.page], place));
        }
    });
    if (progress.cancelled()) return cancelledError();
    return dilate(map, values, kDilationRings * scale);
}

DisplayedSurfaces displayedSurfaces(const std::vector<ImageRgba32f>& pictures, float exposureEv, float strength)
{
    const float factor = shading::exposureFactor(exposureEv) / strength;
    DisplayedSurfaces displayed;
    displayed.strength = strength;
    for (const ImageRgba32f& picture : pictures) {
        ImageRgba8 page(picture.width(), picture.height());
        parallelFor(page.texelCount(), 65536, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const vec4 texel = picture.texels()[i];
                const vec3 encoded = shading::srgbFromLinear(glm::clamp(vec3(texel) * factor, 0.0f, 1.0f));
                page.texels()[i] = u8vec4(vec4(encoded, glm::clamp(texel.w, 0.0f, 1.0f)) * 255.0f + 0.5f);
            }
        });
        displayed.pages.push_back(std::move(page));
    }
    uint64_t texels = 0;
    uint64_t clipped = 0;
    eachTexel(pictures, [&](const vec4& texel) {
        ++texels;
        clipped += brightest(texel) * factor > 1.0f ? 1 : 0;
    });
    displayed.clipped = texels > 0 ? double(clipped) / double(texels) : 0.0;
    return displayed;
}

float surfaceExposure(const std::vector<ImageRgba32f>& pictures)
{
    const float light = lightAbove(pictures, kWhiteShare);
    return light > 0.0f ? math::log2(light) : 0.0f;
}

float surfaceStrength(const std::vector<ImageRgba32f>& pictures, float exposureEv)
{
    return std::clamp(lightAbove(pictures, kClippedShare) * shading::exposureFactor(exposureEv), 1.0f, kMostStrength);
}

} // namespace halflight
