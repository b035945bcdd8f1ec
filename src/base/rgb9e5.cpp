#include "halflight/base/rgb9e5.h"

#include "halflight/base/mathematics.h"
#include "halflight/base/parallel.h"

#include <algorithm>
#include <cmath>

namespace halflight {
namespace {

constexpr int kBias = 15; // of the common exponent

} // namespace

uint32_t packRgb9e5(vec3 color)
{
    for (int c = 0; c < 3; ++c) color[c] = color[c] > 0.0f ? std::min(color[c], kMaxRgb9e5) : 0.0f; // NaN too
    const float largest = std::max({color.x, color.y, color.z});
    int exponent = std::max(-kBias - 1, largest > 0.0f ? std::ilogb(largest) : -kBias - 1) + 1 + kBias;
    float scale = std::ldexp(1.0f, kBias + 9 - exponent);
    if (std::floor(largest * scale + 0.5f) >= 512.0f) {
        ++exponent;
        scale *= 0.5f;
    }
    const auto mantissa = [&](float c) { return uint32_t(std::floor(c * scale + 0.5f)); };
    return mantissa(color.x) | (mantissa(color.y) << 9) | (mantissa(color.z) << 18) | (uint32_t(exponent) << 27);
}

vec3 unpackRgb9e5(uint32_t texel)
{
    const vec3 mantissas(texel & 0x1ff, (texel >> 9) & 0x1ff, (texel >> 18) & 0x1ff);
    return mantissas * std::ldexp(1.0f, int(texel >> 27) - kBias - 9);
}

float rgb9e5Unit(const ImageRgb32f& image)
{
    float largest = 0.0f;
    for (const vec3& texel : image.texels()) largest = std::max({largest, texel.x, texel.y, texel.z});
    return largest > 0.0f ? math::exp2(std::ceil(math::log2(largest / kMaxRgb9e5))) : 1.0f;
}

Image<uint32_t> encodeRgb9e5(const ImageRgb32f& picture, float unit)
{
    Image<uint32_t> page(picture.width(), picture.height());
    parallelFor(picture.texelCount(), 65536, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) page.data()[i] = packRgb9e5(picture.data()[i] / unit);
    });
    return page;
}

ImageRgb32f decodeRgb9e5(const Image<uint32_t>& page, float unit)
{
    ImageRgb32f decoded(page.width(), page.height());
    for (std::size_t i = 0; i < page.texelCount(); ++i) decoded.data()[i] = unit * unpackRgb9e5(page.data()[i]);
    return decoded;
}

} // namespace halflight
