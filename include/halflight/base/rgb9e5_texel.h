// Packs a texel of RGB9E5 (rgb9e5.h), in C++20 and in GLSL 4.60: a device that adds up pages writes what the baker
// would. Below shading/language.h, which base may not include; of its words it needs none but the function's beginning.
#ifndef HALFLIGHT_BASE_RGB9E5_TEXEL_H
#define HALFLIGHT_BASE_RGB9E5_TEXEL_H

#ifdef __cplusplus
#include "halflight/base/math.h"

#include <cstdint>

#define HL_RGB9E5_FN inline
#define HL_RGB9E5_CONST inline constexpr
namespace halflight::rgb9e5 {
using glm::floatBitsToUint;
using glm::floor;
using glm::max;
using glm::min;
using glm::uintBitsToFloat;
using uint = uint32_t;
#else
#define HL_RGB9E5_FN
#define HL_RGB9E5_CONST const
#endif

// The largest value of the format, 511/512 * 2^16.
HL_RGB9E5_CONST float kMostOfTexel = 65408.0f;

// 0 to the largest value; what is no number becomes 0.
HL_RGB9E5_FN float inTexel(float x)
{
    return x > 0.0f ? min(x, kMostOfTexel) : 0.0f;
}

// A mantissa to the nearest, halves up. `scale` is a power of two, so that the product is exact.
HL_RGB9E5_FN uint mantissaOfTexel(float x, float scale)
{
    return uint(floor(x * scale + 0.5f));
}

// EXT_texture_shared_exponent (Khronos 2009), "Encode": the largest channel chooses the exponent, biased by 15.
HL_RGB9E5_FN uint packTexel(vec3 color)
{
    vec3 c = vec3(inTexel(color.x), inTexel(color.y), inTexel(color.z));
    float largest = max(c.x, max(c.y, c.z));
    int exponent = max(int(floatBitsToUint(largest) >> 23) - 127, -16) + 16;
    float scale = uintBitsToFloat(uint(127 + 24 - exponent) << 23);
    if (mantissaOfTexel(largest, scale) >= 512u) {
        exponent += 1;
        scale *= 0.5f;
    }
    return mantissaOfTexel(c.x, scale) | (mantissaOfTexel(c.y, scale) << 9) | (mantissaOfTexel(c.z, scale) << 18) |
           (uint(exponent) << 27);
}

#ifdef __cplusplus
} // namespace halflight::rgb9e5
#endif
#undef HL_RGB9E5_FN
#undef HL_RGB9E5_CONST

#endif
