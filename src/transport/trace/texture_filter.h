#pragma once
// Texels of a texture at a coordinate.

#include "halflight/scene/scene.h"
#include "halflight/shading/texture_filter.h"

#include <array>

namespace halflight {

static_assert(int(Texture::Wrap::Repeat) == shading::kWrapRepeat &&
              int(Texture::Wrap::ClampToEdge) == shading::kWrapClampToEdge &&
              int(Texture::Wrap::MirroredRepeat) == shading::kWrapMirroredRepeat);

/// `pixels`: of the texture, or a smaller copy of them.
inline u8vec4 nearestTexel(const Texture& texture, const ImageRgba8& pixels, vec2 uv)
{
    const ivec2 at = shading::texelPlace(uv, pixels.size(), int(texture.wrapU), int(texture.wrapV), true).low;
    return pixels(at.x, at.y);
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
    const shading::TexelPlace at =
        shading::texelPlace(uv, pixels.size(), int(texture.wrapU), int(texture.wrapV), texture.nearest);
    return {{pixels(at.low.x, at.low.y), pixels(at.high.x, at.low.y), pixels(at.low.x, at.high.y),
             pixels(at.high.x, at.high.y)},
            at.weight};
}

} // namespace halflight
