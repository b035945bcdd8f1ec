#include "base/webp.h"
#include "halflight/base/encoded_image.h"
#include "halflight/base/file.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <memory>
#include <png.h>

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_NO_STDIO
#define STBI_NO_HDR // loops for ever on some damaged files; decodeRgbe() reads them
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb_image.h>
#pragma GCC diagnostic pop

namespace halflight {

Result<std::vector<std::byte>> encodePng(const ImageRgba8& image)
{
    if (image.empty()) return Error{ErrorCode::InvalidArgument, "an image without texels cannot be written as PNG"};
    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    png.width = png_uint_32(image.width());
    png.height = png_uint_32(image.height());
    png.format = PNG_FORMAT_RGBA;
    // The most that a picture takes: to ask libpng how much this one takes encodes it a first time.
    png_alloc_size_t byteCount = PNG_IMAGE_PNG_SIZE_MAX(png);
    const std::unique_ptr<std::byte[]> bytes(new std::byte[byteCount]); // without zeros
    if (!png_image_write_to_memory(&png, bytes.get(), &byteCount, 0, image.data(), 0, nullptr)) {
        return Error{ErrorCode::WriteFailed, std::string("PNG encoding failed (") + png.message + ")"};
    }
    return std::vector<std::byte>(bytes.get(), bytes.get() + byteCount);
}

Status writePng(const std::filesystem::path& path, const ImageRgba8& image)
{
    const auto bytes = encodePng(image);
    if (!bytes) return bytes.error();
    return writeFileAtomically(path, bytes->data(), bytes->size());
}

Result<ImageRgba8> readPng(const std::filesystem::path& path)
{
    const auto bytes = readFile(path);
    if (!bytes) return bytes.error();
    return decodeImage(bytes->data(), bytes->size());
}

Result<ivec2> encodedImageSize(const std::byte* bytes, std::size_t byteCount)
{
    if (byteCount == 0 || byteCount > std::size_t(std::numeric_limits<int>::max())) {
        return Error{ErrorCode::FileInvalid, byteCount == 0 ? "image is empty" : "image is larger than 2 GiB"};
    }
    int width = 0;
    int height = 0;
    if (isWebp(bytes, byteCount)) {
        if (!decodesWebp()) return Error{ErrorCode::Unsupported, "image is WebP, and this build has no libwebp"};
        if (!webpSize(bytes, byteCount, width, height)) return Error{ErrorCode::FileInvalid, "WebP image is damaged"};
    } else {
        constexpr int kMaxSide = 32768;
        int channels = 0;
        const auto* data = reinterpret_cast<const stbi_uc*>(bytes);
        if (!stbi_info_from_memory(data, int(byteCount), &width, &height, &channels) || width > kMaxSide ||
            height > kMaxSide) {
            return Error{ErrorCode::FileInvalid, "image is neither PNG nor JPEG, or is damaged"};
        }
    }
    // Deflate packs 1032:1 at best (RFC 1951) and JPEG less, so more texels than that are forged; small ones need no
    // proof.
    if (std::size_t(width) * std::size_t(height) > std::max<std::size_t>(std::size_t(1) << 24, byteCount * 1032)) {
        return Error{ErrorCode::FileInvalid, "image claims more texels than its bytes can hold"};
    }
    return ivec2(width, height);
}

Result<ImageRgba8> decodeImage(const std::byte* bytes, std::size_t byteCount)
{
    // The header first, so that a forged size is refused before it is allocated.
    const auto size = encodedImageSize(bytes, byteCount);
    if (!size) return size.error();
    if (isWebp(bytes, byteCount)) {
        ImageRgba8 image(size->x, size->y);
        if (!decodeWebp(bytes, byteCount, image)) return Error{ErrorCode::FileInvalid, "WebP image is damaged"};
        return image;
    }
    const auto* data = reinterpret_cast<const stbi_uc*>(bytes);
    int width = 0;
    int height = 0;
    int channels = 0;
    const std::unique_ptr<stbi_uc, void (*)(void*)> pixels(
        stbi_load_from_memory(data, int(byteCount), &width, &height, &channels, 4), stbi_image_free);
    if (!pixels) {
        const char* reason = stbi_failure_reason();
        return Error{ErrorCode::FileInvalid,
                     std::string("image cannot be decoded (") + (reason ? reason : "unknown") + ")"};
    }
    ImageRgba8 image(width, height);
    std::memcpy(image.data(), pixels.get(), image.texelCount() * sizeof(u8vec4));
    return image;
}

} // namespace halflight
