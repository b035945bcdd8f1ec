#pragma once
// Reflection at one point of a surface: glTF's BRDF, and directions that are sampled from it.

#include "transport/trace/materials.h"

#include "halflight/bake/integrator.h"
#include "halflight/shading/brdf_sampling.h"

#include <algorithm>
#include <cmath>

namespace halflight {

class Scattering {
public:
    /// `normal`: unit, with the normal map. `view`: unit, towards the ray's origin.
    Scattering(const SurfaceReflectance& surface, vec3 normal, vec3 geometricNormal, vec3 view)
        : surface_(surface), normal_(normal), geometricNormal_(geometricNormal), view_(view),
          alpha_(shading::ggxAlphaOf(surface.roughness)),
          specularShare_(shading::specularSamplingShare(surface.baseColor, surface.metallic, surface.roughness,
                                                        surface.specular,
                                                        std::min(std::abs(glm::dot(normal, view)), 1.0f)))
    {}

    /// Radiance towards the view for light from `direction` with this illuminance at normal incidence. Light from below
    /// the triangle is not excluded here: where the triangle is in the way, the light's shadow ray finds it.
    [[nodiscard]] vec3 reflected(vec3 direction, vec3 illuminance) const
    {
        return shading::reflectLight(surface_.baseColor, surface_.metallic, surface_.roughness, surface_.specular,
                                     normal_, view_, direction, illuminance);
    }
    /// A direction above the triangle, or zero where the sample lies below it.
    [[nodiscard]] vec3 sample(float uLobe, vec2 u) const
    {
        const vec3 direction = shading::sampleBrdf(normal_, view_, alpha_, specularShare_, uLobe, u);
        return above(direction) ? direction : vec3(0.0f);
    }
    /// Density of sample() per steradian.
    [[nodiscard]] float pdf(vec3 direction) const
    {
        return shading::brdfPdf(normal_, view_, direction, alpha_, specularShare_);
    }
    [[nodiscard]] bool above(vec3 direction) const { return glm::dot(direction, geometricNormal_) > 0.0f; }
    [[nodiscard]] bool black() const
    {
        return surface_.baseColor == vec3(0.0f) && surface_.specular == 0.0f && surface_.metallic == 0.0f;
    }

private:
    SurfaceReflectance surface_;
    vec3 normal_;
    vec3 geometricNormal_;
    vec3 view_;
    float alpha_;
    float specularShare_;
};

} // namespace halflight
