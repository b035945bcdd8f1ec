#pragma once
// Subtractive's main light (spec S21…S25): the mixed directional light that has occlusion in the probes.

#include "halflight/bake/integrator.h"

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace halflight {

struct Gather;

struct MainLight {
    std::string name;
    vec3 towardsLight{0.0f}; ///< unit
    vec3 illuminance{0.0f};  ///< lux, on a surface that faces it
    float shadowStrength = 1.0f;
    int channel = 0;
    std::vector<vec3> unshadowed; ///< lux by texel, without shadows; 0 inside geometry
    std::vector<float> arriving;  ///< of that by texel, 0…1 in steps of a 255th, without the shadow strength

    /// Its direct light in the lightmap, lux.
    [[nodiscard]] vec3 at(std::size_t texel) const
    {
        return glm::mix(1.0f, arriving[texel], shadowStrength) * unshadowed[texel];
    }
    void addTo(std::vector<vec3>& irradiance) const;
    /// Adds its first moments (IrradianceEstimate::moment).
    void addMomentTo(std::vector<vec3>& moments) const;
    /// `arriving` in its channel, 1 in the others.
    [[nodiscard]] std::vector<vec4> mask() const;
};

/// The scene's, without values by texel; none when it has none, or is baked for another mode.
std::optional<MainLight> findMainLight(const Scene& scene);

/// Fills in what the light gives each texel of the map. `estimates` are those of Gather::irradiance(). False when
/// cancelled.
bool bakeMainLight(const Gather& gather, std::span<const IrradianceEstimate> estimates, MainLight& main,
                   const Progress& progress);

/// The lower limit of subtractive shadows for scenes whose author names none, lux: `otherLight`, all but the main
/// light's direct light, of texels that face the main light and lie in its shadow; by colour channel their median. With
/// a mask the guess is exact, so that the limit only covers rounding: a value that one in twenty of them is below.
vec3 chooseShadowColor(const MainLight& main, const std::vector<vec3>& otherLight, const std::vector<uint8_t>& valid,
                       bool hasMask);

} // namespace halflight
