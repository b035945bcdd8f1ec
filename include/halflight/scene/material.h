#pragma once
// Materials and their textures: plain structs, as the scene's (scene.h). Colours are linear Rec. 709.

#include "halflight/base/math.h"
#include "halflight/base/shared_image.h"

#include <array>
#include <limits>
#include <string>

namespace halflight {

/// 8-bit image and sampler. Whether texels are sRGB-encoded follows from the use: base colour and emissive are, others
/// not.
struct Texture {
    enum class Wrap { Repeat, ClampToEdge, MirroredRepeat };
    std::string name;
    SharedImage<u8vec4> pixels;
    Wrap wrapU = Wrap::Repeat;
    Wrap wrapV = Wrap::Repeat;
    bool nearest = false;   ///< magnify without filtering
    int sourceTexture = -1; ///< index in the glTF file's "textures"
};

/// Texture coordinate sets of a file that are read: TEXCOORD_0 to TEXCOORD_7.
constexpr int kTexCoordSets = 8;

/// Reference from a material to a texture, with KHR_texture_transform: uv' = offset + R(rotation) * (scale * uv),
/// R = [cos, sin; -sin, cos] (row-major) as that extension writes it.
struct TextureRef {
    int texture = -1; ///< index into Scene::textures, -1 = none
    int texCoord = 0; ///< which of MeshPart::uv; the textures of one material read two sets at most
    vec2 offset{0.0f};
    vec2 scale{1.0f};
    float rotationRadians = 0.0f;

    explicit operator bool() const { return texture >= 0; }
};

/// Light that a face of glass lets through at normal incidence: all but the 4 % that an index of refraction of 1.5
/// reflects.
constexpr float kGlassTransmittance = 0.96f;

/// Attenuation distance of a volume that takes nothing.
constexpr float kNoAttenuation = std::numeric_limits<float>::infinity();

struct Material {
    enum class AlphaMode { Opaque, Mask, Blend };
    std::string name;
    std::string group;    ///< light group of its emission (light_groups.h); empty = none
    int bakedGroup = -1;  ///< index into BakedScene::groups, -1 = none
    vec3 whiteNits{0.0f}; ///< of a member of a group, emission at the weight 1
    vec4 baseColor{1.0f}; ///< linear, times texture and vertex colour
    TextureRef baseColorTexture;
    float metallic = 1.0f;
    float roughness = 1.0f;
    float specular = 1.0f; ///< KHR_materials_specular: strength of the dielectric reflection, 0 = purely diffuse
    TextureRef metallicRoughnessTexture; ///< G roughness, B metallic
    TextureRef normalTexture;
    float normalScale = 1.0f;
    TextureRef occlusionTexture; ///< R
    float occlusionStrength = 1.0f;
    vec3 emissiveNits{0.0f}; ///< factor times KHR_materials_emissive_strength: radiance emitted, cd/m2
    TextureRef emissiveTexture;
    AlphaMode alphaMode = AlphaMode::Opaque; ///< what alpha means; glass is drawn blended whatever it says
    float alphaCutoff = 0.5f;
    float transmission = 0.0f;      ///< KHR_materials_transmission's factor; 0 where the material is unlit
    TextureRef transmissionTexture; ///< R
    bool tinted = false;            ///< light that passes where it is blended takes its base colour
    vec3 attenuationColor{1.0f};    ///< KHR_materials_volume: what is left of white light after attenuationMeters
    float attenuationMeters = kNoAttenuation;
    float thickness = 0.0f;      ///< in the mesh's space, below a surface of no solid; 0: no volume behind the surface
    TextureRef thicknessTexture; ///< G scales the thickness
    bool doubleSided = false;
    bool unlit = false;
    bool castShadows = true; ///< shadows want these of the object and of the material, in the bake and at run time
    bool receiveShadows = true;
    int sourceMaterial = -1;

    /// Whether it lets a share of light through, by alpha or as glass.
    [[nodiscard]] bool isBlended() const { return alphaMode == AlphaMode::Blend || transmission > 0.0f; }
    /// Whether it stops all light everywhere.
    [[nodiscard]] bool isOpaque() const { return alphaMode == AlphaMode::Opaque && transmission <= 0.0f; }
    /// Share of the surface that alpha leaves at a point.
    [[nodiscard]] float presence(float alpha) const
    {
        if (alphaMode == AlphaMode::Mask) return alpha < alphaCutoff ? 0.0f : 1.0f;
        return alphaMode == AlphaMode::Blend ? glm::clamp(alpha, 0.0f, 1.0f) : 1.0f;
    }
    /// Share of light that it stops at a point: by the point's alpha, metallic and value of the transmission texture.
    /// shading::coverageOf() is the same.
    [[nodiscard]] float coverage(float alpha, float metallicThere, float transmissionTexel) const
    {
        const float glass = kGlassTransmittance * transmission * transmissionTexel * (1.0f - metallicThere);
        return presence(alpha) * (1.0f - glass);
    }

    /// Light that passes a point, by colour: of the glass the base colour, of what alpha leaves open as well where the
    /// material is tinted. `behind`: what a thickness behind the surface lets through. Grey glass passes 1 -
    /// coverage().
    [[nodiscard]] vec3 passed(vec4 color, float metallicThere, float transmissionTexel, vec3 behind) const
    {
        const float there = presence(color.w);
        const vec3 base = glm::clamp(vec3(color), 0.0f, 1.0f);
        const vec3 open = (1.0f - there) * (tinted && alphaMode == AlphaMode::Blend ? base : vec3(1.0f));
        const float glass = there * kGlassTransmittance * transmission * transmissionTexel * (1.0f - metallicThere);
        return open + glass * base * behind;
    }
    /// Whether it has a volume that takes light on the way through it.
    [[nodiscard]] bool attenuates() const
    {
        return transmission > 0.0f && thickness > 0.0f && attenuationMeters < kNoAttenuation &&
               attenuationColor != vec3(1.0f);
    }

    [[nodiscard]] std::array<const TextureRef*, 7> textureRefs() const
    {
        return {&baseColorTexture, &metallicRoughnessTexture, &normalTexture,   &occlusionTexture,
                &emissiveTexture,  &transmissionTexture,      &thicknessTexture};
    }
};

} // namespace halflight
