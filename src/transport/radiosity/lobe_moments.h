#pragma once
// What the specular lobes of a patch reflect, and to which side.

#include "transport/random/sampler.h"
#include "transport/sample/specular_lobe.h"

#include "halflight/shading/lobe_moments.h"

namespace halflight {

/// Sums over samples of a patch (shading/lobe_moments.h).
struct LobeMoments : shading::LobeSums {
    LobeMoments() : shading::LobeSums{} {}

    void add(const shading::LobeSums& o)
    {
        albedo += o.albedo;
        evenLight += o.evenLight;
        evenCosine += o.evenCosine;
        exitance += o.exitance;
        sampledExitance += o.sampledExitance;
        sampledMoment += o.sampledMoment;
        normal += o.normal;
    }
    /// First moment of what a patch reflects: `diffuse` (lux) by its diffuse part; by its lobes `even` (lux) of even
    /// light, and direct light.
    [[nodiscard]] vec3 momentOf(float diffuse, float even, vec3 unitNormal) const
    {
        constexpr float kDiffuse = 2.0f / 3.0f; // mean cosine of a diffuse surface; of lobes where there are no samples
        const float cosine = evenLight > 0.0f ? evenCosine / evenLight : kDiffuse;
        const vec3 direction = sampledExitance > 0.0f ? sampledMoment / sampledExitance : kDiffuse * unitNormal;
        return (kDiffuse * diffuse + even * cosine) * unitNormal + luminance(exitance) * direction;
    }
    /// The surface at a sample, and its reflection of even light.
    void addSurface(const SurfaceReflectance& surface, const SurfacePoint& point, Sampler& sampler)
    {
        const vec3 toLight = shading::evenDirection(point.normal, sampler.next2());
        shading::addLobeSurface(*this, lobeOf(surface, point), toLight, sampler.next2());
    }
    /// Light that arrives from one direction, in lux on the surface.
    void addLight(const SurfaceReflectance& surface, const SurfacePoint& point, vec3 toLight, vec3 irradiance,
                  Sampler& sampler)
    {
        if (irradiance == vec3(0.0f)) return;
        shading::addLobeLight(*this, lobeOf(surface, point), toLight, irradiance, sampler.next2());
    }

private:
    static shading::LobeSurface lobeOf(const SurfaceReflectance& surface, const SurfacePoint& point)
    {
        return {surface.f0(), surface.f90(), SpecularLobe::roughnessOf(surface), point.normal, point.geometricNormal};
    }
};

} // namespace halflight
