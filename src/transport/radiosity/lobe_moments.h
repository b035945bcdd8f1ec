#pragma once
// What the specular lobes of a patch reflect, and to which side.

#include "transport/random/sampler.h"
#include "transport/sample/specular_lobe.h"

#include "halflight/base/finite.h"
#include "halflight/shading/sampling.h"

#include <algorithm>

namespace halflight {

/// Sums over samples of a patch. "Even" is light with the same radiance from all around.
struct LobeMoments {
    vec3 albedo{0.0f};            ///< share of even light that the lobes reflect
    float evenLight = 0.0f;       ///< luminance of sampled reflections of even light
    float evenCosine = 0.0f;      ///< the same times the cosine of their directions
    vec3 exitance{0.0f};          ///< lux: direct light that the lobes reflect
    float sampledExitance = 0.0f; ///< luminance of sampled reflections of direct light
    vec3 sampledMoment{0.0f};     ///< the same times their directions
    vec3 normal{0.0f};            ///< of the surface

    void add(const LobeMoments& o)
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
        normal += point.normal;
        albedo += shading::averageSpecular(surface.f0(), surface.f90(), SpecularLobe::roughnessOf(surface));
        vec3 tangent;
        vec3 bitangent;
        shading::orthonormalBasis(point.normal, tangent, bitangent);
        const vec3 local = shading::sampleCosineHemisphere(sampler.next2());
        const vec3 toLight = local.x * tangent + local.y * bitangent + local.z * point.normal;
        const Sample s = reflect(surface, point, toLight, sampler);
        evenLight += luminance(s.share);
        evenCosine += luminance(s.share) * glm::dot(s.direction, point.normal);
    }
    /// Light that arrives from one direction, in lux on the surface: by reciprocity the lobe reflects of it what it
    /// sends to that side of even light. Samples give the mean direction alone, since their shares are noisy.
    void addLight(const SurfaceReflectance& surface, const SurfacePoint& point, vec3 toLight, vec3 irradiance,
                  Sampler& sampler)
    {
        if (irradiance == vec3(0.0f)) return;
        const float roughness = SpecularLobe::roughnessOf(surface);
        const float cosine = glm::clamp(glm::dot(point.normal, toLight), 0.0f, 1.0f);
        const vec3 share = shading::environmentSpecular(surface.f0(), surface.f90(), roughness, cosine);
        exitance += irradiance * glm::max(share, 0.0f);
        const Sample s = reflect(surface, point, toLight, sampler);
        sampledExitance += luminance(irradiance * s.share);
        sampledMoment += luminance(irradiance * s.share) * s.direction;
    }

private:
    struct Sample {
        vec3 share{0.0f};
        vec3 direction{0.0f};
    };
    /// A direction to which a lobe reflects light, and the share that it reflects. The lobe is sampled from the light's
    /// side, where it is the same (reciprocity).
    static Sample reflect(const SurfaceReflectance& surface, const SurfacePoint& point, vec3 toLight, Sampler& sampler)
    {
        const SpecularLobe lobe(surface, point, -toLight);
        const vec3 direction = lobe.sample(sampler.next2());
        if (direction == vec3(0.0f)) return {};
        const vec3 share = lobe.reflected(direction, vec3(1.0f / lobe.pdf(direction)));
        return isFinite(share) ? Sample{share, direction} : Sample{};
    }
};

} // namespace halflight
