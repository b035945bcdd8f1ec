#pragma once
// Material properties at points of triangles: coverage, emission, reflectance.

#include "halflight/bake/integrator.h"
#include "halflight/base/image.h"
#include "halflight/base/math.h"
#include "halflight/scene/scene.h"
#include "halflight/shading/brdf.h"

#include <cstdint>
#include <span>
#include <vector>

namespace halflight {

/// A material reduced to what light transport reads.
struct TransportMaterial {
    vec3 baseColorFactor{0.0f};
    float opacity = 1.0f; ///< base colour alpha
    vec3 emission{0.0f};  ///< nits
    TextureRef baseColor;
    TextureRef metallicRoughness; ///< B channel scales metallic, G roughness
    float metallicFactor = 0.0f;
    float roughnessFactor = 1.0f;
    float specular = 1.0f; ///< KHR_materials_specular's factor
    TextureRef emissive;
    const Material* source = nullptr; ///< for its coverage
    bool opaque = true;               ///< Material::isOpaque()
    bool blended = false;             ///< Material::isBlended()
    TextureRef transmission;
    TextureRef thickness;
    vec3 attenuation{0.0f}; ///< of the volume behind the surface, in 1/m
    bool tints = false;     ///< light that passes takes a colour
    bool doubleSided = false;
    bool unlit = false;
};

/// Parameters of the BRDF at one point (shading/brdf.h).
struct SurfaceReflectance {
    vec3 baseColor{0.0f}; ///< 0…1
    float metallic = 0.0f;
    float roughness = 1.0f;
    float specular = 1.0f;

    [[nodiscard]] vec3 f0() const { return shading::specularF0Of(baseColor, metallic, specular); }
    [[nodiscard]] float f90() const { return shading::specularF90Of(metallic, specular); }
    /// Albedo of the diffuse part beside the specular lobe, the mean over all directions.
    [[nodiscard]] vec3 diffuseAlbedo() const
    {
        return shading::diffuseAlbedoOf(baseColor, metallic) * shading::averageDiffuseShare(f0(), f90());
    }
    /// Albedo of a diffuse surface in place of both parts.
    [[nodiscard]] vec3 transportAlbedo() const { return shading::transportAlbedo(baseColor, metallic, roughness); }
};

/// Materials of flattened geometry with their textures. Immutable after construction.
class Materials {
public:
    /// `geometry` and `scene` outlive it.
    Materials(const Scene& scene, const BakeGeometry& geometry);

    [[nodiscard]] const TransportMaterial& of(uint32_t triangle) const;
    /// Probability that a ray hits the surface there: Material::coverage().
    [[nodiscard]] float coverageAt(uint32_t triangle, vec2 barycentric) const;
    /// What glass does to light that passes a point of it.
    struct Glass {
        float coverage = 1.0f;  ///< coverageAt()
        vec3 passed{0.0f};      ///< Material::passed(), through a thickness where the surface is of no solid
        vec3 attenuation{0.0f}; ///< of the solid behind the surface, in 1/m
    };
    /// `direction`: of the light, in the world.
    [[nodiscard]] Glass glassAt(uint32_t triangle, vec2 barycentric, vec3 direction) const;
    /// Metres of a unit of thickness below a triangle, which is in its mesh's space.
    [[nodiscard]] float metersOfThickness(uint32_t triangle) const { return glm::length(thicknessAlong(triangle)); }
    [[nodiscard]] vec3 emissionAt(uint32_t triangle, vec2 barycentric) const;
    [[nodiscard]] SurfaceReflectance reflectanceAt(uint32_t triangle, vec2 barycentric) const;
    /// Whether the back of a triangle is hidden: inside a solid, or the back of a single-sided surface.
    [[nodiscard]] bool backIsHidden(uint32_t triangle) const
    {
        return geometry_.isSolid(triangle) || !of(triangle).doubleSided;
    }

    /// By number; the last one is glTF's default material.
    [[nodiscard]] std::span<const TransportMaterial> all() const { return materials_; }
    [[nodiscard]] int textureCount() const { return int(smallTextures_.size()); }
    /// As colours are read; empty where nothing reads it.
    [[nodiscard]] const ImageRgba8& smallTexture(int index) const { return smallTextures_[std::size_t(index)]; }
    [[nodiscard]] const Texture& texture(int index) const { return scene_.textures[std::size_t(index)]; }
    /// Where a texture is read, KHR_texture_transform included.
    [[nodiscard]] vec2 textureCoordinate(uint32_t triangle, vec2 barycentric, const TextureRef& ref) const;
    /// Interpolated, linear; 1 in scenes without vertex colours.
    [[nodiscard]] vec4 vertexColor(uint32_t triangle, vec2 barycentric) const;

private:
    [[nodiscard]] vec4 dataAt(uint32_t triangle, vec2 barycentric, const TextureRef& ref) const;
    [[nodiscard]] float alphaAt(uint32_t triangle, vec2 barycentric, const TransportMaterial& material) const;
    [[nodiscard]] vec3 thicknessAlong(uint32_t triangle) const;
    [[nodiscard]] vec3 thicknessLeaves(uint32_t triangle, vec2 barycentric, vec3 direction) const;
    void findTints();
    [[nodiscard]] u8vec4 smallTexel(uint32_t triangle, vec2 barycentric, const TextureRef& ref) const;

    const Scene& scene_;
    const BakeGeometry& geometry_;
    std::vector<TransportMaterial> materials_; ///< the last one is glTF's default material
    /// Textures averaged down to at most 256 texels a side. Diffuse transport needs no finer detail, and they fit
    /// caches.
    std::vector<ImageRgba8> smallTextures_;
};

} // namespace halflight
