#include "base/webp.h"

#include <cstring>

#if HALFLIGHT_WEBP
#include <webp/decode.h>
#endif

namespace halflight {

bool isWebp(const std::byte* bytes, std::size_t byteCount)
{
    return byteCount >= 12 && std::memcmp(bytes, "RIFF", 4) == 0 && std::memcmp(bytes + 8, "WEBP", 4) == 0;
}

#if HALFLIGHT_WEBP

bool decodesWebp()
{
    return true;
}

bool webpSize(const std::byte* bytes, std::size_t byteCount, int& width, int& height)
{
    WebPBitstreamFeatures features;
    const auto* data = reinterpret_cast<const uint8_t*>(bytes);
    if (WebPGetFeatures(data, byteCount, &features) != VP8_STATUS_OK || features.has_animation != 0) return false;
    width = features.width;
    height = features.height;
    return width > 0 && height > 0;
}

bool decodeWebp(const std::byte* bytes, std::size_t byteCount, ImageRgba8& image)
{
    const std::size_t byteLength = image.texelCount() * sizeof(u8vec4);
    return WebPDecodeRGBAInto(reinterpret_cast<const uint8_t*>(bytes), byteCount,
                              reinterpret_cast<uint8_t*>(image.data()), byteLength,
                              image.width() * int(sizeof(u8vec4))) != nullptr;
}

#else // without the library

bool decodesWebp()
{
    return false;
}

bool webpSize(const std::byte*, std::size_t, int&, int&)
{
    return false;
}

bool decodeWebp(const std::byte*, std::size_t, ImageRgba8&)
{
    return false;
}

#endif

} // namespace halflight
