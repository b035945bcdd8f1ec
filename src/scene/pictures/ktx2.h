#pragma once
// KTX 2.0 files (Khronos, "KTX File Format Specification, version 2.0") with one level of RGB9E5 or half floats,
// Zstandard-compressed.

#include "halflight/base/image.h"

#include <span>

namespace halflight {

/// Zstandard's level where a bake writes: lightmaps of Sponza (2048²) take 0.1 to 0.4 % more bytes than at level 12,
/// and a quarter of its seconds on the one thread that packs a page.
constexpr int kZstdLevelOfBakes = 7;

/// VK_FORMAT_E5B9G9R9_UFLOAT_PACK32, no mipmaps, supercompression scheme 2 (Zstandard).
Result<std::vector<std::byte>> encodeKtx2(const Image<uint32_t>& rgb9e5, int zstdLevel = kZstdLevelOfBakes);
/// The same with VK_FORMAT_R16G16B16A16_SFLOAT: texels of halfTexels().
Result<std::vector<std::byte>> encodeKtx2(const Image<uint64_t>& half, int zstdLevel = kZstdLevelOfBakes);

/// Four half floats a texel, clamped to 0…65504, alpha 1; and back.
Image<uint64_t> halfTexels(const ImageRgb32f& page);
vec3 floatsOf(uint64_t half);

/// Keeps so many bits (1…9) of each mantissa, the rest rounded: texels that Zstandard finds more alike. The brightest
/// channel of a texel errs by at most 2^-bits of its value.
void roundMantissas(Image<uint32_t>& rgb9e5, int bits);

/// Reads what encodeKtx2 writes, and the same uncompressed; half floats are rounded to RGB9E5.
Result<Image<uint32_t>> decodeKtx2(std::span<const std::byte> bytes);

} // namespace halflight
