#include "bake/stages.h"

#include "halflight/base/parallel.h"
#include "halflight/shading/directional.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/packing.hpp>

namespace halflight {
namespace {

/// EXT_texture_shared_exponent (Khronos 2009): mantissas of nine bits, one exponent with bias 15. GLM's packer covers
/// only half of the format's range.
uint32_t packRgb9e5(vec3 color)
{
    for (int c = 0; c < 3; ++c) color[c] = color[c] > 0.0f ? std::min(color[c], kMaxRgb9e5) : 0.0f; // NaN too
    const float largest = std::max({color.x, color.y, color.z});
    int exponent = std::max(-16, largest > 0.0f ? std::ilogb(largest) : -16) + 1 + 15;
    float scale = std::ldexp(1.0f, 15 + 9 - exponent);
    if (std::floor(largest * scale + 0.5f) >= 512.0f) {
        ++exponent;
        scale *= 0.5f;
    }
    const auto mantissa = [&](float c) { return uint32_t(std::floor(c * scale + 0.5f)); };
    return mantissa(color.x) | (mantissa(color.y) << 9) | (mantissa(color.z) << 18) | (uint32_t(exponent) << 27);
}

} // namespace

float lightmapUnitFor(const std::vector<ImageRgb32f>& pages)
{
    float brightest = 0.0f;
    for (const ImageRgb32f& page : pages) {
        for (const vec3 texel : page.texels()) {
            for (int c = 0; c < 3; ++c) {
                if (std::isfinite(texel[c])) brightest = std::max(brightest, texel[c]);
            }
        }
    }
    float unit = 1.0f;
    while (brightest > kMaxRgb9e5 * unit) unit *= 2.0f;
    return unit;
}

std::vector<Image<uint32_t>> encodeLightmap(const std::vector<ImageRgb32f>& pages, float unitLux)
{
    std::vector<Image<uint32_t>> encoded;
    for (const ImageRgb32f& page : pages) {
        Image<uint32_t> out(page.width(), page.height());
        parallelFor(page.texelCount(), 65536, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                out.data()[i] = packRgb9e5(page.data()[i] / unitLux);
            }
        });
        encoded.push_back(std::move(out));
    }
    return encoded;
}

ImageRgb32f decodeLightmap(const Image<uint32_t>& page, float unitLux)
{
    ImageRgb32f decoded(page.width(), page.height());
    for (std::size_t i = 0; i < page.texelCount(); ++i)
        decoded.data()[i] = unitLux * glm::unpackF3x9_E1x5(page.data()[i]);
    return decoded;
}

std::vector<ImageRgba8> encodeDirections(const std::vector<ImageRgb32f>& irradiance,
                                         const std::vector<ImageRgb32f>& moments)
{
    std::vector<ImageRgba8> encoded;
    for (std::size_t p = 0; p < irradiance.size(); ++p) {
        ImageRgba8 out(irradiance[p].width(), irradiance[p].height());
        parallelFor(out.texelCount(), 65536, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const float light = luminance(irradiance[p].data()[i]);
                const vec3 direction = light > 0.0f ? moments[p].data()[i] / light : vec3(0.0f);
                out.data()[i] = u8vec4(vec4(shading::encodeMeanDirection(direction), 1.0f) * 255.0f + 0.5f);
            }
        });
        encoded.push_back(std::move(out));
    }
    return encoded;
}

std::vector<ImageRgba8> encodeShadowmask(const std::vector<ImageRgba32f>& pages)
{
    std::vector<ImageRgba8> encoded;
    for (const ImageRgba32f& page : pages) {
        ImageRgba8 out(page.width(), page.height());
        for (std::size_t i = 0; i < page.texelCount(); ++i) {
            out.data()[i] = u8vec4(glm::clamp(page.data()[i], 0.0f, 1.0f) * 255.0f + 0.5f);
        }
        encoded.push_back(std::move(out));
    }
    return encoded;
}

} // namespace halflight
