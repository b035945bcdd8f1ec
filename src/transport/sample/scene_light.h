#pragma once
// The light sources of a scene.

#include "transport/random/sampler.h"
#include "transport/sample/emitters.h"
#include "transport/sample/light_reach.h"
#include "transport/sample/lights.h"
#include "transport/sample/sky_light.h"

#include "halflight/scene/light_groups.h"
#include "halflight/shading/luminance.h"
#include "halflight/shading/sampling.h"

#include <array>
#include <span>
#include <vector>

namespace halflight {

using shading::grayOf;
using shading::shadowOf;

/// Punctual lights, emissive surfaces and the sky, with what chooses among them. Immutable after construction.
class SceneLight {
public:
    /// `surfaces` outlives it.
    SceneLight(const Scene& scene, const RayScene& surfaces, LightUse use, const LightComponents& components);

    [[nodiscard]] const std::vector<PunctualLight>& lights() const { return lights_; }
    /// Calls visit(light, its index) for the lights whose range may reach a point. The order is always the same.
    template<typename Visit> void forLightsNear(vec3 point, Visit visit) const
    {
        reach_.each(point, [&](uint32_t index) { visit(lights_[index], index); });
    }
    [[nodiscard]] const Emitters& emitters() const { return emitters_; }
    [[nodiscard]] const SkyLight& sky() const { return sky_; }
    /// Number of components; 0: light is estimated as one.
    [[nodiscard]] int components() const { return components_.count; }
    /// Of a picture, whose bright places are sampled.
    [[nodiscard]] int skyComponent() const { return components_.ofSky[0]; }
    /// Whether parts of the sky are of different components.
    [[nodiscard]] bool splitsSky() const
    {
        const auto [zenith, horizon, ground] = components_.ofSky;
        return zenith != horizon || zenith != ground;
    }
    /// Calls visit(component, radiance) for what of the sky's radiance in a direction is of a component: a gradient's
    /// colours may be of three.
    template<typename Visit> void splitSky(vec3 direction, vec3 radiance, Visit visit) const
    {
        if (splitsSky())
            splitShares(shading::skyRadiance(vec3(1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1), direction), visit);
        else
            visit(components_.ofSky[0], radiance);
    }
    /// The same of shares of the zenith, the horizon and the ground.
    template<typename Visit> void splitShares(vec3 shares, Visit visit) const
    {
        const auto [zenith, horizon, ground] = components_.ofSky;
        const Sky& colors = sky_.sky();
        visit(zenith, shares.x * colors.zenith);
        visit(horizon, shares.y * colors.horizon);
        visit(ground, shares.z * colors.ground);
    }
    /// Of the zenith, the horizon and the ground; of a picture all the same.
    [[nodiscard]] const std::array<int, 3>& skyComponents() const { return components_.ofSky; }
    /// Of a triangle's emission, and of a material's; -1: no material.
    [[nodiscard]] int emissionComponent(uint32_t triangle) const
    {
        return components_.count == 0 ? 0 : componentOfMaterial(surfaces_.geometry().partOf(triangle).material);
    }
    [[nodiscard]] int componentOfMaterial(int material) const
    {
        return material < 0 || components_.count == 0 ? 0 : components_.ofMaterial[std::size_t(material)];
    }
    /// Whether there are emitters or bright places in the sky, which receivers sample.
    [[nodiscard]] bool samplesEmission() const { return !emitters_.empty() || sky_.samples(); }
    /// Components of these; none where light is estimated as one.
    [[nodiscard]] std::span<const int> emittingComponents() const { return emittingComponents_; }

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
    /// `probability`; `disc` is the point of the unit disc that the choice has. Where there are components, one of them
    /// is chosen first: half in proportion to their light here, half evenly, so that a dim one has samples too.
    template<typename Contribution>
    LightChoice chooseLight(const SurfacePoint& point, Sampler& sampler, Contribution contribution) const;
    /// `direct` = without the lights' indirect multipliers.
    LightChoice choosePunctual(const SurfacePoint& point, bool direct, Sampler& sampler) const;
    /// Sets of lights of which chooseFrom() chooses: one for each component with lights that bounce, at least one.
    [[nodiscard]] std::size_t choosers() const { return choosers_.size(); }
    LightChoice choosePunctualFrom(std::size_t chooser, const SurfacePoint& point, Sampler& sampler) const;
    /// chooseLight() of one of these sets.
    template<typename Contribution> LightChoice chooseLightFrom(std::size_t chooser, const SurfacePoint& point,
                                                                Sampler& sampler, Contribution contribution) const;

    /// The lights of a component that bounce.
    struct Chooser {
        int component = 0;
        LightTree tree; ///< empty if they are few
        std::vector<uint32_t> lightOfItem;
        std::vector<uint32_t> always; ///< lights that are not in the tree
    };
    [[nodiscard]] const Chooser& chooser(std::size_t number) const { return choosers_[number]; }

private:
    void addChooser(int component);
    /// `total`: receives the sum of the contributions' luminances.
    template<typename Contribution> LightChoice chooseFrom(const Chooser& chooser, const SurfacePoint& point, float u,
                                                           vec2 disc, Sampler& sampler, Contribution contribution,
                                                           float& total) const;
    template<typename Contribution>
    LightChoice chooseComponent(const SurfacePoint& point, Sampler& sampler, Contribution contribution) const;

    const RayScene& surfaces_;
    LightComponents components_;
    std::vector<PunctualLight> lights_;
    Emitters emitters_;
    LightReach reach_;
    std::vector<int> emittingComponents_;
    std::vector<Chooser> choosers_;
    SkyLight sky_;
};

// One light per call (shading::LightReservoir). If lights are many, one point or spot light of the tree enters the
// reservoir, with contribution / probability.
template<typename Contribution>
SceneLight::LightChoice SceneLight::chooseFrom(const Chooser& chooser, const SurfacePoint& point, float u, vec2 disc,
                                               Sampler& sampler, Contribution contribution, float& total) const
{
    shading::LightReservoir reservoir = shading::lightReservoir(u);
    const auto consider = [&](uint32_t index, float probability) {
        shading::considerLight(reservoir, index, contribution(lights_[index], disc, probability));
    };
    for (const uint32_t index : chooser.always) consider(index, 1.0f);
    if (!chooser.tree.empty()) {
        const LightTree::Choice choice = chooser.tree.sample(point.position, point.normal, sampler.next1());
        if (choice.probability > 0.0f) consider(chooser.lightOfItem[choice.item], choice.probability);
    }
    total = reservoir.total;
    if (reservoir.chosen == ~0u) return {};
    return {&lights_[reservoir.chosen], shading::contributionOfChosen(reservoir), disc};
}

template<typename Contribution> SceneLight::LightChoice
SceneLight::chooseLight(const SurfacePoint& point, Sampler& sampler, Contribution contribution) const
{
    if (lights_.empty()) return {};
    return choosers_.size() > 1 ? chooseComponent(point, sampler, contribution)
                                : chooseLightFrom(0, point, sampler, contribution);
}

template<typename Contribution>
SceneLight::LightChoice SceneLight::chooseLightFrom(std::size_t chooser, const SurfacePoint& point, Sampler& sampler,
                                                    Contribution contribution) const
{
    if (lights_.empty()) return {};
    const float u = sampler.next1();
    const vec2 disc = shading::sampleDisc(sampler.next2());
    float total = 0.0f;
    return chooseFrom(choosers_[chooser], point, u, disc, sampler, contribution, total);
}

template<typename Contribution> SceneLight::LightChoice
SceneLight::chooseComponent(const SurfacePoint& point, Sampler& sampler, Contribution contribution) const
{
    constexpr std::size_t kMost = kMostLightGroups + 1;
    std::array<LightChoice, kMost> choices;
    std::array<float, kMost> totals{};
    const float within = sampler.next1(); // of a component, one of which is chosen
    const vec2 disc = shading::sampleDisc(sampler.next2());
    float all = 0.0f;
    int reaching = 0;
    for (std::size_t c = 0; c < choosers_.size(); ++c) {
        choices[c] = chooseFrom(choosers_[c], point, within, disc, sampler, contribution, totals[c]);
        all += totals[c];
        reaching += totals[c] > 0.0f ? 1 : 0;
    }
    float u = sampler.next1();
    std::size_t last = 0;
    float lastProbability = 0.0f;
    for (std::size_t c = 0; c < choosers_.size(); ++c) {
        if (!(totals[c] > 0.0f)) continue;
        last = c;
        lastProbability = shading::probabilityOfSet(totals[c], all, reaching);
        if (u < lastProbability) break;
        u -= lastProbability;
    }
    if (reaching == 0) return {};
    choices[last].unshadowed /= lastProbability;
    return choices[last];
}

} // namespace halflight
