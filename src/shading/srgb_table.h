#pragma once
// For the processor alone: shaders read textures in sRGB formats.

#include "halflight/shading/color.h"

#include <array>

namespace halflight::shading {

/// linearFromSrgb() of n / 255.
inline const std::array<float, 256> kLinearFromSrgb8 = [] {
    std::array<float, 256> table{};
    for (int n = 0; n < 256; ++n) table[std::size_t(n)] = linearFromSrgb(float(n) / 255.0f);
    return table;
}();

} // namespace halflight::shading
