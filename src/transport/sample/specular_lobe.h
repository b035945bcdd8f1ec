#pragma once
// The specular lobe of a surface between a light source and a receiver.

#include "transport/trace/ray_tracer.h"

#include "halflight/shading/brdf_sampling.h"

#include <algorithm>

namespace halflight {

/// Largest component of a colour.
inline float brightest(vec3 color)
{
    return std::max({color.x, color.y, color.z});
}

/// How surfaces reflect light to other surfaces: as diffuse ones of shading::transportAlbedo(), or by glTF's BRDF.
enum class Bounces { Diffuse, Glossy };

/// The specular part of shading::reflectLight() at a hit, seen against the direction of the ray. Lobes are at least
/// kLeastRoughness wide, so that a small lamp's mirror image is no single bright sample (Kaplanyan and Dachsbacher
/// 2013, "Path Space Regularization for Holistic and Robust Light Transport").
class SpecularLobe {
public:
    static constexpr float kLeastRoughness = shading::kLeastLobeRoughness; ///< perceptual

    [[nodiscard]] static float roughnessOf(const SurfaceReflectance& surface)
    {
        return std::max(surface.roughness, kLeastRoughness);
    }
    /// `direction`: of the ray that hits the surface.
    SpecularLobe(const SurfaceReflectance& surface, const SurfacePoint& point, vec3 direction,
                 float leastRoughness = kLeastRoughness)
        : f0_(surface.f0()), f90_(surface.f90()), roughness_(std::max(surface.roughness, leastRoughness)),
          normal_(point.normal), geometricNormal_(point.geometricNormal), view_(-direction)
    {}

    /// Radiance along the ray for light from `direction` with this illuminance at normal incidence.
    [[nodiscard]] vec3 reflected(vec3 direction, vec3 illuminance) const
    {
        return shading::reflectSpecular(f0_, f90_, shading::ggxAlphaOf(roughness_), normal_, view_, direction,
                                        illuminance);
    }
    /// A direction above the triangle, or zero where the sample lies below it.
    [[nodiscard]] vec3 sample(vec2 u) const
    {
        const vec3 direction = shading::sampleBrdf(normal_, view_, shading::ggxAlphaOf(roughness_), 1.0f, 0.0f, u);
        return glm::dot(direction, geometricNormal_) > 0.0f ? direction : vec3(0.0f);
    }
    /// Density of sample() per steradian.
    [[nodiscard]] float pdf(vec3 direction) const
    {
        return shading::brdfPdf(normal_, view_, direction, shading::ggxAlphaOf(roughness_), 1.0f);
    }

private:
    vec3 f0_;
    float f90_;
    float roughness_;
    vec3 normal_;
    vec3 geometricNormal_;
    vec3 view_;
};

} // namespace halflight
