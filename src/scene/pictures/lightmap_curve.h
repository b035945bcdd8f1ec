#pragma once
// Lightmaps in 8 bits a channel: texel = scale * (c / 255)^exponent. Neighbouring texels get numbers near each other,
// of which lossless WebP makes a fifth of what RGB9E5 takes.

#include "halflight/base/image.h"

#include <functional>
#include <span>

namespace halflight {

struct LightmapCurve {
    float scale = 1.0f;
    float exponent = 2.0f;
};

/// The curve with the least error for these pages (RGB9E5).
LightmapCurve bestCurve(std::span<const Image<uint32_t>> pages);

ImageRgba8 encodeByCurve(const Image<uint32_t>& rgb9e5, const LightmapCurve& curve);
Image<uint32_t> decodeByCurve(const ImageRgba8& image, const LightmapCurve& curve);

/// A page's texel by its number.
using TexelOf = std::function<vec3(std::size_t)>;
/// Of a page that outlives it.
TexelOf texelsOf(const Image<uint32_t>& rgb9e5);

/// Error of a lightmap page of `count` texels against another: of each texel's channel that errs most, relative to the
/// texel's brightest, or to 1/4096 of the page's brightest where that is more.
struct LightmapError {
    double mean = 0.0; ///< over texels that are not black
    double most = 0.0;
};
LightmapError lightmapError(std::size_t count, const TexelOf& truth, const TexelOf& other);

} // namespace halflight
