#include "transport/sample/scene_light.h"

#include <algorithm>

namespace halflight {

SceneLight::SceneLight(const Scene& scene, const RayScene& surfaces, LightUse use)
    : lights_(punctualLights(scene, use)), emitters_(surfaces), sky_(scene.sky)
{
    // Up to 8 lights are chosen by their exact unshadowed contributions.
    constexpr std::ptrdiff_t kFewLights = 8;
    if (std::count_if(lights_.begin(), lights_.end(), [](const PunctualLight& l) { return l.bounces; }) > kFewLights) {
        punctualTree_ = punctualTree(lights_, lightOfItem_);
    }
    std::vector<const PunctualLight*> all;
    for (uint32_t i = 0; i < lights_.size(); ++i) {
        all.push_back(&lights_[i]);
        const bool inTree = !punctualTree_.empty() && lights_[i].type != shading::kLightDirectional;
        if (lights_[i].bounces && !inTree) alwaysChosenFrom_.push_back(i);
    }
    reach_ = LightReach(std::move(all));
}

SceneLight::LightChoice SceneLight::choosePunctual(const SurfacePoint& point, bool direct, Sampler& sampler) const
{
    return chooseLight(point, sampler, [&](const PunctualLight& light, vec2 disc, float probability) {
        if (light.isArea()) {
            const LightRay ray = sampleLightRay(light, point.position, disc);
            return light.irradianceBy(ray, point.position, point.normal) *
                   ((direct ? 1.0f : light.indirectMultiplier) / probability);
        }
        const shading::LightSample s = light.at(point.position);
        const float cosine = glm::dot(point.normal, s.direction);
        if (cosine <= 0.0f) return vec3(0.0f);
        return s.illuminance * (cosine * (direct ? 1.0f : light.indirectMultiplier) / probability);
    });
}

} // namespace halflight
