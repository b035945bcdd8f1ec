#include "bake/settings/quality.h"

#include <algorithm>

namespace halflight {
namespace {

/// Previews have directions from this share of metal on, of the lightmapped area.
constexpr float kMuchMetal = 0.1f;

/// Mean metalness of a material, 0…1.
float metalOf(const Scene& scene, const Material& material)
{
    const int number = material.metallicRoughnessTexture.texture;
    if (material.metallic <= 0.0f || number < 0) return material.metallic;
    const ImageRgba8& pixels = scene.textures[std::size_t(number)].pixels;
    double sum = 0.0;
    for (const u8vec4 pixel : pixels.texels()) sum += double(pixel.b) / 255.0;
    return material.metallic * float(sum / double(std::max<std::size_t>(pixels.texelCount(), 1)));
}

/// Calls visit(object, part, square metres in the world) for all that is lightmapped.
template<typename Visit> void forEachLightmappedPart(const Scene& scene, const Visit& visit)
{
    for (const Object& object : scene.objects) {
        if (!object.isStatic || object.lightmapScale <= 0.0f || object.mesh < 0) continue;
        const mat3 axes(object.worldFromObject);
        for (const MeshPart& part : scene.meshes[std::size_t(object.mesh)].parts) {
            double area = 0.0;
            for (std::size_t i = 0; i + 2 < part.indices.size(); i += 3) {
                const vec3 a = part.positions[part.indices[i]];
                const vec3 u = axes * (part.positions[part.indices[i + 1]] - a);
                const vec3 v = axes * (part.positions[part.indices[i + 2]] - a);
                area += 0.5 * double(glm::length(glm::cross(u, v)));
            }
            visit(object, part, area);
        }
    }
}

/// Share of the lightmapped surfaces' area that is metal, 0…1. Surfaces without a material do not count.
float metalShare(const Scene& scene)
{
    std::vector<float> metal;
    for (const Material& material : scene.materials) metal.push_back(metalOf(scene, material));
    double all = 0.0;
    double ofMetal = 0.0;
    forEachLightmappedPart(scene, [&](const Object&, const MeshPart& part, double area) {
        all += area;
        if (part.material >= 0) ofMetal += area * double(metal[std::size_t(part.material)]);
    });
    return all > 0.0 ? float(ofMetal / all) : 0.0f;
}

} // namespace

BakeQuality resolveQuality(const BakeSettings& settings)
{
    BakeQuality q{};
    switch (settings.quality) {
    case Quality::Preview:
        q = {32, 16, 1024, 128, 128};
        break;
    case Quality::Medium:
        q = {96, 32, 2048, 256, 128};
        break;
    case Quality::High:
        q = {256, 64, 4096, 512, 256};
        break;
    case Quality::Ultra:
        q = {1024, 128, 4096, 1024, 256};
        break;
    }
    q.noiseTarget = settings.noiseTarget;
    if (q.noiseTarget > 0.0f) q.samples = 4096;
    if (settings.samples > 0) q.samples = settings.samples;
    if (settings.shadowSamples > 0) q.shadowSamples = settings.shadowSamples;
    q.bounces = settings.bounces;
    q.directional = settings.directional.value_or(settings.quality != Quality::Preview);
    if (settings.lightmapSize > 0) q.lightmapSize = settings.lightmapSize;
    return q;
}

double expectedSamples(const Scene& scene, const BakeSettings& settings)
{
    constexpr double kFilled = 0.8; // of a page, mostly
    const BakeQuality quality = resolveQuality(settings);
    const double page = kFilled * double(quality.lightmapSize) * double(quality.lightmapSize);
    const UnwrapSettings unwrap = unwrapSettings(scene, settings);
    const double perMeter = unwrap.texelsPerMeter > 0.0f ? unwrap.texelsPerMeter : unwrap.mostTexelsPerMeter;
    double texels = 0.0;
    forEachLightmappedPart(scene, [&](const Object& object, const MeshPart&, double area) {
        const double density = perMeter * double(object.lightmapScale);
        texels += density * density * area;
    });
    if (perMeter == 0.0) texels = page;
    if (unwrap.texelsPerMeter == 0.0f) texels = std::min(texels, page);
    return texels * double(quality.samples);
}

UnwrapSettings unwrapSettings(const Scene& scene, const BakeSettings& settings)
{
    UnwrapSettings unwrap;
    unwrap.uvMode = settings.uvMode;
    unwrap.texelsPerMeter = settings.texelsPerMeter;
    unwrap.pageSize = resolveQuality(settings).lightmapSize;
    unwrap.paddingTexels = settings.paddingTexels;
    unwrap.cutPage = settings.lightmapSize == 0;
    if (settings.lightmapSize == 0 && settings.texelsPerMeter == 0.0f)
        unwrap.mostTexelsPerMeter = sceneDensity(scene, unwrap.pageSize);
    return unwrap;
}

BakeQuality qualityOf(const BakeSettings& settings, const Scene& scene)
{
    BakeQuality q = resolveQuality(settings);
    if (!settings.directional && !q.directional) q.directional = metalShare(scene) >= kMuchMetal;
    return q;
}

} // namespace halflight
