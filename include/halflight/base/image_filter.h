#pragma once

#include "halflight/base/image.h"

namespace halflight {

/// The value at a position in texels (texel i covers i … i + 1), filtered bilinearly and clamped to the edge. The image
/// has at least one texel.
template<typename Texel> Texel bilinear(const Image<Texel>& image, vec2 place)
{
    const vec2 corner = glm::floor(place - 0.5f);
    const vec2 f = place - 0.5f - corner;
    const auto at = [&](int dx, int dy) {
        const ivec2 texel = glm::clamp(ivec2(corner) + ivec2(dx, dy), ivec2(0), image.size() - 1);
        return image(texel.x, texel.y);
    };
    return glm::mix(glm::mix(at(0, 0), at(1, 0), f.x), glm::mix(at(0, 1), at(1, 1), f.x), f.y);
}

} // namespace halflight
