#pragma once
// The light sources of a scene.

#include "transport/sample/emitters.h"
#include "transport/sample/light_reach.h"
#include "transport/sample/lights.h"
#include "transport/sample/sampler.h"
#include "transport/sample/sky_light.h"

#include "halflight/scene/scene.h"
#include "halflight/shading/sampling.h"

#include <vector>

namespace halflight {

/// Share of a light that its shadow leaves, by colour.
inline vec3 shadowOf(const PunctualLight& light, vec3 transmittance)
{
    const auto of = [&](float share) { return glm::mix(1.0f, share, light.shadowStrength); };
    return {of(transmittance.x), of(transmittance.y), of(transmittance.z)};
}

/// The same share for what has no colour, as masks: of coloured light that of its luminance.
inline float grayOf(vec3 transmittance)
{
    const bool gray = transmittance.x == transmittance.y && transmittance.x == transmittance.z;
    return gray ? transmittance.x : luminance(transmittance);
}

/// Punctual lights, emissive surfaces and the sky, with what chooses among them. Immutable after construction.
class SceneLight {
public:
    /// `surfaces` outlives it.
    SceneLight(const Scene& scene, const RayScene& surfaces, LightUse use);

    [[nodiscard]] const std::vector<PunctualLight>& lights() const { return lights_; }
    /// Calls visit(light, its index) for the lights whose range may reach a point. The order is always the same.
    template<typename Visit> void forLightsNear(vec3 point, Visit visit) const
    {
        reach_.each(point, [&](uint32_t index) { visit(lights_[index], index); });
    }
    [[nodiscard]] const Emitters& emitters() const { return emitters_; }
    [[nodiscard]] const SkyLight& sky() const { return sky_; }
    /// Whether there are emitters or bright places in the sky, which receivers sample.
    [[nodiscard]] bool samplesEmission() const { return !emitters_.empty() || sky_.samples(); }

    /// A sample among the punctual lights that bounce: a light and a point of the unit disc.
    struct LightChoice {
        const PunctualLight* light = nullptr;
        vec3 unshadowed{0.0f}; ///< irradiance (or what chooseLight() is given) / probability of the light
        vec2 disc{0.0f};

        [[nodiscard]] vec3 irradiance(vec3 transmittance) const
        {
            return light != nullptr ? unshadowed * shadowOf(*light, transmittance) : vec3(0.0f);
        }
    };
    /// One light, chosen in proportion to the luminance of contribution(light, disc, probability), which is divided by
    /// `probability`; `disc` is the point of the unit disc that the choice has.
    template<typename Contribution>
    LightChoice chooseLight(const SurfacePoint& point, Sampler& sampler, Contribution contribution) const;
    /// `direct` = without the lights' indirect multipliers.
    LightChoice choosePunctual(const SurfacePoint& point, bool direct, Sampler& sampler) const;

private:
    std::vector<PunctualLight> lights_;
    Emitters emitters_;
    LightReach reach_;
    LightTree punctualTree_; ///< of the lights that bounce; empty if they are few
    std::vector<uint32_t> lightOfItem_;
    std::vector<uint32_t> alwaysChosenFrom_; ///< lights that bounce and are not in the tree
    SkyLight sky_;
};

// One light per call, chosen in proportion to the unshadowed contributions (Shirley et al. 1996, "Monte Carlo
// Techniques for Direct Lighting Calculations", section 5). The choice is a weighted reservoir of size one (Chao 1982,
// "A General Purpose Unequal Probability Sampling Plan"): each light rescales the random number, so any number of
// lights needs no memory. If lights are many, one point or spot light of the tree enters the reservoir, with
// contribution / probability.
template<typename Contribution> SceneLight::LightChoice
SceneLight::chooseLight(const SurfacePoint& point, Sampler& sampler, Contribution contribution) const
{
    if (lights_.empty()) return {};
    float u = sampler.next1();
    const vec2 disc = shading::sampleDisc(sampler.next2());
    float total = 0.0f;
    float chosenWeight = 0.0f;
    const PunctualLight* chosen = nullptr;
    vec3 chosenContribution(0.0f);
    const auto consider = [&](const PunctualLight& light, float probability) {
        const vec3 unshadowed = contribution(light, disc, probability);
        const float weight = luminance(unshadowed);
        if (weight <= 0.0f) return;
        total += weight;
        const float take = weight / total;
        if (u < take) {
            chosen = &light;
            chosenWeight = weight;
            chosenContribution = unshadowed;
            u /= take;
        } else {
            u = (u - take) / (1.0f - take);
        }
    };
    for (const uint32_t index : alwaysChosenFrom_) consider(lights_[index], 1.0f);
    if (!punctualTree_.empty()) {
        const LightTree::Choice choice = punctualTree_.sample(point.position, point.normal, sampler.next1());
        if (choice.probability > 0.0f) consider(lights_[lightOfItem_[choice.item]], choice.probability);
    }
    if (chosen == nullptr) return {};
    return {chosen, chosenContribution * (total / chosenWeight), disc};
}

} // namespace halflight
