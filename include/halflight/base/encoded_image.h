#pragma once

#include "halflight/base/image.h"

#include <algorithm>
#include <cstdint>

namespace halflight {

/// Width and height of an encoded image (PNG, JPEG and what else stb_image reads, WebP) from its header. A size that
/// the bytes cannot hold is an error.
Result<ivec2> encodedImageSize(const std::byte* bytes, std::size_t byteCount);

/// The most texels that images of so many encoded bytes may have in all; 4 bytes each when decoded. 2^26 texels (256
/// MiB) need no proof, more must come from bytes that can hold them (deflate packs 1032:1 at best, RFC 1951), and 2^31
/// texels (8 GiB) are the most.
constexpr uint64_t mostTexels(uint64_t encodedBytes)
{
    constexpr uint64_t kFree = uint64_t(1) << 26;
    constexpr uint64_t kMost = uint64_t(1) << 31;
    return encodedBytes < kMost / 1032 ? std::min(kMost, kFree + 1032 * encodedBytes) : kMost;
}

/// Whether decodeImage() reads WebP, and the functions below write it: this build was made with libwebp.
bool decodesWebp();

/// Lossy WebP of quality 1…100.
Result<std::vector<std::byte>> encodeWebp(const ImageRgba8& image, int quality);
/// Lossless WebP that keeps colour where alpha is 0. `smallest`: takes nine times as long, for about 1.5 % less
/// (a shadowmask of 1024 x 1024 texels: 3.7 s and 228 kB against 0.4 s and 231 kB).
Result<std::vector<std::byte>> encodeWebpLossless(const ImageRgba8& image, bool smallest = false);

} // namespace halflight
