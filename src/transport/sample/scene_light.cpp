#include "transport/sample/scene_light.h"

#include <algorithm>

namespace halflight {

SceneLight::SceneLight(const Scene& scene, const RayScene& surfaces, LightUse use, const LightComponents& components)
    : surfaces_(surfaces), components_(components), lights_(punctualLights(scene, use, components)),
      emitters_(surfaces, components), sky_(scene.sky)
{
    for (int c = 0; c < std::max(components.count, 1); ++c) addChooser(c);
    if (choosers_.empty()) choosers_.emplace_back();
    std::vector<const PunctualLight*> all;
    for (const PunctualLight& light : lights_) all.push_back(&light);
    reach_ = LightReach(std::move(all));
    for (int c = 0; c < components.count; ++c) {
        const bool emits = std::ranges::any_of(emitters_.all(), [&](const auto& e) { return e.component == c; });
        if (emits || (sky_.samples() && skyComponent() == c)) emittingComponents_.push_back(c);
    }
}

void SceneLight::addChooser(int component)
{
    // Up to 8 lights are chosen by their exact unshadowed contributions.
    constexpr std::ptrdiff_t kFewLights = 8;
    const auto isOne = [&](const PunctualLight& l) { return l.bounces && l.component == component; };
    Chooser chooser{component, {}, {}, {}};
    if (std::count_if(lights_.begin(), lights_.end(), isOne) > kFewLights)
        chooser.tree = punctualTree(lights_, component, chooser.lightOfItem);
    for (uint32_t i = 0; i < lights_.size(); ++i) {
        const bool inTree = !chooser.tree.empty() && lights_[i].type != shading::kLightDirectional;
        if (isOne(lights_[i]) && !inTree) chooser.always.push_back(i);
    }
    if (!chooser.always.empty() || !chooser.tree.empty()) choosers_.push_back(std::move(chooser));
}

namespace {

/// Unoccluded irradiance on a surface, over the probability; for SceneLight::chooseLight().
auto irradianceOf(const SurfacePoint& point, bool direct)
{
    return [&point, direct](const PunctualLight& light, vec2 disc, float probability) {
        return shading::sampledIrradiance(light, point.position, point.normal, disc,
                                          direct ? 1.0f : light.indirectMultiplier, probability);
    };
}

} // namespace

SceneLight::LightChoice SceneLight::choosePunctual(const SurfacePoint& point, bool direct, Sampler& sampler) const
{
    return chooseLight(point, sampler, irradianceOf(point, direct));
}

SceneLight::LightChoice SceneLight::choosePunctualFrom(std::size_t chooser, const SurfacePoint& point,
                                                       Sampler& sampler) const
{
    return chooseLightFrom(chooser, point, sampler, irradianceOf(point, false));
}

} // namespace halflight
