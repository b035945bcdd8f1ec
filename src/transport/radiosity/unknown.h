#pragma once
// Unknowns of the radiosity equation.

#include "transport/radiosity/lobe_moments.h"
#include "transport/radiosity/radiance_cache.h"

#include <algorithm>

namespace halflight {

/// Unknown of the linear system with its constants.
struct Unknown {
    vec3 gathered{0.0f}; ///< irradiance of sky and emitters along rays
    vec3 direct{0.0f};   ///< irradiance of sampled lights
    vec3 albedo{0.0f};
    LobeMoments lobes;
    float directCount = 0.0f;
    float rays = 0.0f;
    float minDistance = 0.0f;

    /// Of a component, takes the surface and the counts of the sum.
    void completeFrom(const Unknown& all)
    {
        gathered /= all.rays;
        direct /= all.directCount;
        albedo = all.albedo;
        lobes.exitance /= all.directCount;
        lobes.albedo = all.lobes.albedo;
        lobes.evenLight = all.lobes.evenLight;
        lobes.evenCosine = all.lobes.evenCosine;
        lobes.normal = all.lobes.normal;
        rays = all.rays;
    }

    /// Radiance of an unknown with the exitance M and the first moment m of what its diffuse part and its lobes
    /// reflect, over the hemisphere: those of R + A . d are M = pi R + 2/3 pi A_n, m_n = 2/3 pi R + pi/2 A_n, m_t =
    /// pi/4 A_t along the normal and the tangents. `mean`: M / pi; `diffuseExitance`: luminance of the diffuse part.
    [[nodiscard]] PatchRadiance radianceOf(vec3 mean, float diffuseExitance) const
    {
        constexpr float kMostTilt = 0.9f; // radiance stays above 0 in all directions
        const float exitance = kPi * luminance(mean);
        const float length = glm::length(lobes.normal);
        if (length <= 0.0f || exitance <= 0.0f) return {mean, minDistance};
        const vec3 normal = lobes.normal / length;
        const float ofEven = std::max(exitance - diffuseExitance - luminance(lobes.exitance), 0.0f);
        const vec3 moment = lobes.momentOf(diffuseExitance, ofEven, normal);
        const float along = glm::dot(moment, normal);
        const vec3 across = moment - along * normal;
        const vec3 slope = (18.0f / kPi) * (along - 2.0f / 3.0f * exitance) * normal + (4.0f / kPi) * across;
        const float shift = (18.0f / kPi) * (0.5f * exitance - 2.0f / 3.0f * along) - exitance / kPi;
        const float excess = glm::length(slope) - kMostTilt * shift;
        const float part = excess > 0.0f ? std::min(1.0f, kMostTilt * exitance / kPi / excess) : 1.0f;
        const float radiance = exitance / kPi + part * shift;
        return {mean * (radiance * kPi / exitance), minDistance, part * slope / radiance};
    }
};

} // namespace halflight
