#pragma once
// Materials as the renderer reads them: textures at full resolution with bilinear filtering, and normal maps.

#include "transport/trace/ray_tracer.h"

#include "halflight/scene/scene.h"

#include <vector>

namespace halflight {

/// Immutable after construction.
class DetailedMaterials {
public:
    /// `scene` and `surfaces` outlive it.
    DetailedMaterials(const Scene& scene, const RayTracer& surfaces);

    /// Without a specular lobe for unlit surfaces, which carry light on like diffuse ones.
    [[nodiscard]] SurfaceReflectance reflectanceAt(uint32_t triangle, vec2 barycentric) const;
    [[nodiscard]] vec3 emissionAt(uint32_t triangle, vec2 barycentric) const;
    /// The normal with the material's normal map, on the side of `point`'s normal. `back`: that side is the back.
    [[nodiscard]] vec3 mappedNormal(const SurfacePoint& point, bool back) const;

private:
    [[nodiscard]] const Material& of(uint32_t triangle) const;
    [[nodiscard]] const Texture* textureOf(const TextureRef& ref) const;
    /// The interpolated tangent in world space and the sign of the bitangent; zero where there is none.
    [[nodiscard]] vec4 tangentAt(uint32_t triangle, vec2 barycentric) const;

    const Scene& scene_;
    const RayTracer& surfaces_;
    std::vector<float> mirrored_; ///< by part: -1 where the transform mirrors
};

} // namespace halflight
