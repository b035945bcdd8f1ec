#pragma once
// Texels of a texture at a coordinate, by glTF's wrap modes.

#include "halflight/scene/scene.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace halflight {

inline int wrapTexel(int i, int size, Texture::Wrap mode)
{
    if (unsigned(i) < unsigned(size)) return i;
    switch (mode) {
    case Texture::Wrap::ClampToEdge:
        return std::clamp(i, 0, size - 1);
    case Texture::Wrap::MirroredRepeat: {
        const int period = 2 * size;
        const int m = ((i % period) + period) % period;
        return m < size ? m : period - 1 - m;
    }
    default:
        return (size & (size - 1)) == 0 ? i & (size - 1) : ((i % size) + size) % size;
    }
}

/// Index of the texel at a coordinate; 0 for coordinates that are not finite.
inline int texelNumber(float coordinate, int size)
{
    const float t = coordinate * float(size);
    return std::isfinite(t) ? int(std::floor(std::clamp(t, -1.0e9f, 1.0e9f))) : 0;
}

/// `pixels`: of the texture, or a smaller copy of them.
inline u8vec4 nearestTexel(const Texture& texture, const ImageRgba8& pixels, vec2 uv)
{
    return pixels(wrapTexel(texelNumber(uv.x, pixels.width()), pixels.width(), texture.wrapU),
                  wrapTexel(texelNumber(uv.y, pixels.height()), pixels.height(), texture.wrapV));
}

/// The four texels of bilinear filtering; all the same for textures that are not filtered.
struct TexelQuad {
    std::array<u8vec4, 4> texels; ///< by row: (0,0), (1,0), (0,1), (1,1)
    vec2 weight{0.0f};            ///< of the second column and of the second row

    /// Bilinear mean of f(texel).
    template<typename F> auto filtered(F f) const
    {
        const auto top = glm::mix(f(texels[0]), f(texels[1]), weight.x);
        const auto bottom = glm::mix(f(texels[2]), f(texels[3]), weight.x);
        return glm::mix(top, bottom, weight.y);
    }
};

inline TexelQuad texelQuad(const Texture& texture, vec2 uv)
{
    const ImageRgba8& pixels = texture.pixels;
    if (texture.nearest) {
        const u8vec4 texel = nearestTexel(texture, pixels, uv);
        return {{texel, texel, texel, texel}, vec2(0.0f)};
    }
    const vec2 place = uv * vec2(pixels.size()) - 0.5f;
    const int x = texelNumber(place.x / float(pixels.width()), pixels.width());
    const int y = texelNumber(place.y / float(pixels.height()), pixels.height());
    const int x0 = wrapTexel(x, pixels.width(), texture.wrapU);
    const int x1 = wrapTexel(x + 1, pixels.width(), texture.wrapU);
    const int y0 = wrapTexel(y, pixels.height(), texture.wrapV);
    const int y1 = wrapTexel(y + 1, pixels.height(), texture.wrapV);
    return {{pixels(x0, y0), pixels(x1, y0), pixels(x0, y1), pixels(x1, y1)},
            glm::clamp(place - vec2(float(x), float(y)), 0.0f, 1.0f)};
}

} // namespace halflight
