#pragma once

#include "halflight/base/math.h"
#include "halflight/base/result.h"

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

namespace halflight {

/// A width × height array of texels, row 0 at the top (glTF's and Vulkan's v = 0). The value type is any plain struct.
template<typename Texel> class Image {
public:
    Image() = default;
    Image(int width, int height, Texel fill = {})
        : width_(width), height_(height), texels_(std::size_t(width) * std::size_t(height), fill)
    {
        assert(width >= 0 && height >= 0);
    }

    [[nodiscard]] int width() const { return width_; }
    [[nodiscard]] int height() const { return height_; }
    [[nodiscard]] ivec2 size() const { return {width_, height_}; }
    [[nodiscard]] bool empty() const { return texels_.empty(); }
    [[nodiscard]] std::size_t texelCount() const { return texels_.size(); }

    Texel& operator()(int x, int y)
    {
        assert(x >= 0 && x < width_ && y >= 0 && y < height_);
        return texels_[std::size_t(y) * std::size_t(width_) + std::size_t(x)];
    }
    const Texel& operator()(int x, int y) const { return const_cast<Image&>(*this)(x, y); }

    Texel* data() { return texels_.data(); }
    const Texel* data() const { return texels_.data(); }
    std::vector<Texel>& texels() { return texels_; }
    const std::vector<Texel>& texels() const { return texels_; }

private:
    int width_ = 0;
    int height_ = 0;
    std::vector<Texel> texels_;
};

using ImageRgb32f = Image<vec3>;
using ImageRgba32f = Image<vec4>;
using ImageRgba8 = Image<u8vec4>;

/// Writes linear floats as a half- or full-float OpenEXR file (scanlines, ZIP). Written to a temporary name, then
/// renamed.
Status writeExr(const std::filesystem::path& path, const ImageRgb32f& image);
Status writeExr(const std::filesystem::path& path, const ImageRgba32f& image);

/// Reads an OpenEXR file's R, G, B and A (1 when absent) as linear floats. One of R, G and B must be there, and no more
/// than `mostTexels`.
Result<ImageRgba32f> readExr(const std::filesystem::path& path, int64_t mostTexels = int64_t(1) << 40);

/// Writes 8-bit RGBA as PNG, values as they are (no colour conversion). Written to a temporary name, then renamed.
Status writePng(const std::filesystem::path& path, const ImageRgba8& image);
Result<ImageRgba8> readPng(const std::filesystem::path& path);

/// In-memory PNG, for images embedded in other files.
Result<std::vector<std::byte>> encodePng(const ImageRgba8& image);

/// Decodes PNG or JPEG (and what else stb_image reads) from memory to 8-bit RGBA.
Result<ImageRgba8> decodeImage(const std::byte* bytes, std::size_t byteCount);

} // namespace halflight
