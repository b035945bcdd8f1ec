#pragma once
// Materials whose glass gives passing light a colour.

#include "halflight/scene/scene.h"

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

} // namespace halflight
