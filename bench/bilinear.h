#pragma once
// Pages as a sampler that clamps to the edge reads them.

#include "halflight/base/image.h"
#include "halflight/base/math.h"

#include <algorithm>

namespace halflight::bench {

template<typename T> T texelClamped(const Image<T>& page, int x, int y)
{
    return page(std::clamp(x, 0, page.width() - 1), std::clamp(y, 0, page.height() - 1));
}

template<typename T> T bilinear(const Image<T>& page, vec2 texel)
{
    const vec2 p = texel - 0.5f;
    const ivec2 b(glm::floor(p));
    const vec2 f = p - vec2(b);
    return glm::mix(glm::mix(texelClamped(page, b.x, b.y), texelClamped(page, b.x + 1, b.y), f.x),
                    glm::mix(texelClamped(page, b.x, b.y + 1), texelClamped(page, b.x + 1, b.y + 1), f.x), f.y);
}

} // namespace halflight::bench
