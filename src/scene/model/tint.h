#pragma once
// What glass makes of light that passes.

#include "halflight/base/mathematics.h"
#include "halflight/scene/scene.h"

#include <algorithm>

namespace halflight {

/// Whether light that passes takes the base colour.
inline bool passesBaseColor(const Material& material)
{
    return material.transmission > 0.0f || (material.tinted && material.alphaMode == Material::AlphaMode::Blend);
}

/// Whether passing light changes, also to grey; colours of vertices are left aside.
inline bool tintsLight(const Material& material)
{
    const bool hasColor = vec3(material.baseColor) != vec3(1.0f) || material.baseColorTexture;
    return (passesBaseColor(material) && hasColor) || material.attenuates();
}

/// Whether its factors are of different colours; a texture may be grey.
inline bool colorsLight(const Material& material)
{
    const auto gray = [](vec3 color) { return color.x == color.y && color.x == color.z; };
    const bool base = passesBaseColor(material) && (!gray(vec3(material.baseColor)) || material.baseColorTexture);
    return base || (material.attenuates() && !gray(material.attenuationColor));
}

/// Of the volume behind a surface, in 1/m by colour; 0 where it has none (shading::volumeLeaves()).
inline vec3 attenuationOf(const Material& material)
{
    constexpr float kLn2 = 0.69314718f;
    constexpr float kBlack = 1.0e-30f; // a colour of 0 has a logarithm, and leaves nothing
    vec3 perMeter(0.0f);
    for (int c = 0; c < 3 && material.attenuates(); ++c)
        perMeter[c] = -kLn2 * math::log2(std::max(material.attenuationColor[c], kBlack)) / material.attenuationMeters;
    return perMeter;
}

} // namespace halflight
