#pragma once
// Pictures of skies made in code.

#include "halflight/base/image.h"
#include "halflight/scene/scene.h"
#include "halflight/shading/sky.h"

#include <memory>

namespace halflight::test {

/// A picture, unturned, with radiance(direction) at the middle of each texel.
template<typename Radiance> ImageRgb32f skyPicture(int width, const Radiance& radiance)
{
    ImageRgb32f picture(width, width / 2);
    for (int y = 0; y < picture.height(); ++y) {
        for (int x = 0; x < width; ++x) {
            const vec2 uv = (vec2(x, y) + 0.5f) / vec2(picture.size());
            picture(x, y) = radiance(shading::skyPictureDirection(uv, vec2(1, 0)));
        }
    }
    return picture;
}

inline Sky skyOf(ImageRgb32f picture, float rotation = 0.0f)
{
    Sky sky;
    sky.setPicture(std::make_shared<const ImageRgb32f>(std::move(picture)), rotation);
    return sky;
}

/// A disc of this half angle and radiance before a sky of radiance 1.
inline ImageRgb32f sunPicture(int width, vec3 towards, float halfAngle, float nits)
{
    return skyPicture(
        width, [=](vec3 d) { return vec3(glm::dot(d, glm::normalize(towards)) > std::cos(halfAngle) ? nits : 1.0f); });
}

} // namespace halflight::test
