#pragma once
// Subtractive's main light (spec S21…S25): the mixed directional light that has occlusion in the probes.

#include "halflight/bake/integrator.h"

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace halflight {

struct CachedIntegrator;

struct MainLight {
    std::string name;
    std::size_t light = 0;   ///< its place in Scene::lights
    vec3 towardsLight{0.0f}; ///< unit
    vec3 illuminance{0.0f};  ///< lux, on a surface perpendicular to it
    float shadowStrength = 1.0f;
    int channel = 0;
    bool coloredMask = false;        ///< BakingOutput::coloredMask
    std::vector<vec3> unshadowed;    ///< lux by texel, unoccluded; 0 inside geometry
    std::vector<vec3> transmittance; ///< by texel, 0…1 in steps of 1/255, without the shadow strength

    /// Its direct light in the lightmap, lux.
    [[nodiscard]] vec3 at(std::size_t texel) const
    {
        return glm::mix(vec3(1.0f), transmittance[texel], shadowStrength) * unshadowed[texel];
    }
    void addTo(std::vector<vec3>& irradiance) const;
    /// Adds its first moments (IrradianceEstimate::moment).
    void addMomentTo(std::vector<vec3>& moments) const;
    /// `transmittance` in its channel or channels, 1 in the others.
    [[nodiscard]] std::vector<vec4> mask() const;
};

/// The scene's main light, without values by texel; nothing without one, or in other mixing modes.
std::optional<MainLight> findMainLight(const Scene& scene);

/// Fills in the values by texel.
Status bakeMainLight(const CachedIntegrator& cached, MainLight& main, const Progress& progress);

/// Lower limit of subtractive shadows in lux, for scenes that set none: by colour channel the median of `otherLight`
/// over texels that face the main light and lie in its shadow. `otherLight`: all light but the main light's direct
/// light, by texel. With a mask the subtraction is exact and the limit covers rounding: the 0.05 quantile.
vec3 chooseShadowColor(const MainLight& main, const std::vector<vec3>& otherLight, const std::vector<uint8_t>& valid,
                       bool hasMask);

} // namespace halflight
