#pragma once
// RGB9E5: three mantissas of nine bits and a common exponent in 32 bits (EXT_texture_shared_exponent, Khronos 2009;
// VK_FORMAT_E5B9G9R9_UFLOAT_PACK32).

#include "halflight/base/image.h"
#include "halflight/base/rgb9e5_texel.h"

namespace halflight {

/// The largest value.
constexpr float kMaxRgb9e5 = rgb9e5::kMostOfTexel;

/// Clamps to 0…kMaxRgb9e5; NaN becomes 0. GLM's packer covers only half of the format's range.
uint32_t packRgb9e5(vec3 color);

/// The colour of a texel. GLM's calls pow().
vec3 unpackRgb9e5(uint32_t texel);

/// The largest channel of a page; 0 without texels.
float brightestOf(const Image<uint32_t>& page);

/// The power of two that brings the largest value of an image into the upper half of the range; 1 for a black image.
float rgb9e5Unit(const ImageRgb32f& image);

/// Texels over `unit`, packed.
Image<uint32_t> encodeRgb9e5(const ImageRgb32f& picture, float unit = 1.0f);

/// Texels as floats, times `unit`.
ImageRgb32f decodeRgb9e5(const Image<uint32_t>& page, float unit = 1.0f);

} // namespace halflight
