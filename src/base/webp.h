#pragma once
// The only code that includes libwebp.

#include "halflight/base/encoded_image.h"

namespace halflight {

/// Whether the bytes begin as a WebP file does.
bool isWebp(const std::byte* bytes, std::size_t byteCount);

/// False: damaged, or an animation (glTF has none), or no libwebp in this build.
bool webpSize(const std::byte* bytes, std::size_t byteCount, int& width, int& height);

/// Fills `image`, which has the size that webpSize() found. False: damaged.
bool decodeWebp(const std::byte* bytes, std::size_t byteCount, ImageRgba8& image);

} // namespace halflight
