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
    return rgb9e5::packTexel(color);
}

vec3 unpackRgb9e5(uint32_t texel)
{
    const vec3 mantissas(texel & 0x1ff, (texel >> 9) & 0x1ff, (texel >> 18) & 0x1ff);
    return mantissas * std::ldexp(1.0f, int(texel >> 27) - kBias - 9);
}

float brightestOf(const Image<uint32_t>& page)
{
    // Values are mantissa * 2^exponent: as integers they compare without a float for each texel.
    uint64_t most = 0;
    for (const uint32_t texel : page.texels()) {
        const uint32_t mantissa = std::max({texel & 0x1ff, (texel >> 9) & 0x1ff, (texel >> 18) & 0x1ff});
        most = std::max(most, uint64_t(mantissa) << (texel >> 27));
    }
    return std::ldexp(float(most), -kBias - 9);
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
    forEachIndex(page.texelCount(), [&](std::size_t i) { decoded.data()[i] = unit * unpackRgb9e5(page.data()[i]); });
    return decoded;
}

} // namespace halflight
