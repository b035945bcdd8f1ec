// S32. Irradiance pages that the application adds to the baked ones.
#include "render/scene/gpu_scene.h"

#include "halflight/base/mathematics.h"
#include "halflight/base/parallel.h"

#include <glm/gtc/packing.hpp>

#include <algorithm>
#include <cmath>

namespace halflight {
namespace {

constexpr VkFormat kPageFormat = VK_FORMAT_R16G16B16A16_SFLOAT;
constexpr uint32_t kTexelBytes = 8;
constexpr std::size_t kTexelsPerTask = 65536;

float brightest(std::span<const ImageRgb32f> pages)
{
    float result = 0.0f;
    for (const ImageRgb32f& page : pages)
        for (const vec3& texel : page.texels()) result = std::max({result, texel.r, texel.g, texel.b});
    return result;
}

/// Lux of a texel of 1: a power of two that puts the brightest texel just below half of what half floats hold, 65504.
float unitFor(float brightestLux)
{
    constexpr float kSmallest = 1.0e-30f;
    return math::exp2(std::ceil(math::log2(std::max(brightestLux, kSmallest))) - 15.0f);
}

} // namespace

Status checkDynamicLightmaps(const BakedScene& baked, std::span<const ImageRgb32f> irradiance)
{
    const auto bad = [](const std::string& what) { return Error{ErrorCode::InvalidArgument, what, ""}; };
    if (irradiance.empty()) return {};
    if (irradiance.size() != baked.lightmaps.size())
        return bad("the scene has " + std::to_string(baked.lightmaps.size()) + " lightmap pages, and " +
                   std::to_string(irradiance.size()) + " dynamic ones were passed");
    for (const ImageRgb32f& page : irradiance) {
        if (page.empty() || page.size() != irradiance.front().size())
            return bad("dynamic lightmap pages are empty or differ in size");
        const bool good = std::all_of(page.texels().begin(), page.texels().end(), [](vec3 texel) {
            const auto fits = [](float x) { return x >= 0.0f && std::isfinite(x); };
            return fits(texel.r) && fits(texel.g) && fits(texel.b);
        });
        if (!good) return bad("a texel of a dynamic lightmap is below 0 or not finite");
    }
    return {};
}

bool uploadDynamicLightmaps(gpu::Device& device, GpuScene& scene, std::span<const ImageRgb32f> irradiance)
{
    scene.hasDynamicLightmaps = !irradiance.empty();
    if (irradiance.empty()) return false; // the image stays for the next set
    const ivec2 size = irradiance.front().size();
    const gpu::ImageInfo& info = scene.dynamicLightmaps.info();
    const bool fits = info.format == kPageFormat && info.width == uint32_t(size.x) && info.height == uint32_t(size.y) &&
                      info.layers == uint32_t(irradiance.size());
    if (!fits) {
        scene.dynamicLightmaps = {};
        scene.dynamicLightmaps =
            gpu::Image(device, {.format = kPageFormat,
                                .width = uint32_t(size.x),
                                .height = uint32_t(size.y),
                                .layers = uint32_t(irradiance.size()),
                                .array = true,
                                .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT});
    }
    scene.dynamicUnitLux = unitFor(brightest(irradiance));
    gpu::Uploader uploader(device);
    std::vector<std::vector<uint64_t>> texels(irradiance.size());
    std::vector<gpu::Uploader::Level> levels;
    for (std::size_t i = 0; i < irradiance.size(); ++i) {
        texels[i].resize(irradiance[i].texelCount());
        parallelFor(texels[i].size(), kTexelsPerTask, [&](std::size_t begin, std::size_t end) {
            for (std::size_t t = begin; t < end; ++t)
                texels[i][t] = glm::packHalf4x16(vec4(irradiance[i].data()[t] / scene.dynamicUnitLux, 1.0f));
        });
        levels.push_back({0, uint32_t(i), texels[i].data()});
    }
    uploader.image(scene.dynamicLightmaps, levels, kTexelBytes);
    uploader.finish();
    return !fits;
}

} // namespace halflight
