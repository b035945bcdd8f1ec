// Which lights a frame has, and what the bake left for each to do.
#include "halflight/shading/law.h"
#include "halflight/shading/light.h"
#include "render/frame/frame_internal.h"

#include <algorithm>
#include <string_view>
#include <tuple>

namespace halflight {
namespace {

/// Candela, or lux of directional lights.
float power(const Light& light)
{
    return luminance(light.color) * light.intensity * light.area();
}

/// Illuminance the light brings to the camera's surroundings: what it would give a surface at the camera, nearer than a
/// metre counting as a metre. It also orders lights by the solid angle they light up, since both go with power /
/// distance^2.
float importanceOf(const Light& light, vec3 cameraPosition)
{
    if (light.type == LightType::Directional) return power(light);
    return power(light) *
           shading::distanceAttenuation(std::max(glm::distance(light.position(), cameraPosition), 1.0f), 0.0f);
}

bool isMixed(const Light& light)
{
    return light.baking.isBaked && light.baking.bakeType == LightMode::Mixed;
}

/// The order of a frame's lights. Nothing in it depends on the order of the scene's lights, except between lights that
/// are equal in all that is compared, where the choice shows nowhere.
bool before(const Scene& scene, const FrameLight& a, const FrameLight& b)
{
    const Light& la = scene.lights[std::size_t(a.light)];
    const Light& lb = scene.lights[std::size_t(b.light)];
    const auto key = [](const FrameLight& frameLight, const Light& light) {
        const vec3 p = light.type == LightType::Directional ? vec3(0.0f) : light.position();
        const vec3 d = light.type == LightType::Point ? vec3(0.0f) : light.direction();
        return std::tuple(light.type != LightType::Directional, -frameLight.importance, p.x, p.y, p.z,
                          std::string_view(light.name), light.type, d.x, d.y, d.z, light.rangeMeters,
                          light.outerConeRadians, light.sizeMeters.x, light.sizeMeters.y, frameLight.light);
    };
    return key(a, la) < key(b, lb);
}

/// Subtractive's main light: among mixed directional lights the one whose attenuation the probes hold (channel 0), so
/// that a change of intensities at run time cannot pair one light with another's baked shadow; then the brightest.
/// `lights` is in frame order, brightest first.
int findMainLight(const Scene& scene, const std::vector<FrameLight>& lights)
{
    int main = -1;
    for (std::size_t i = 0; i < lights.size(); ++i) {
        const Light& light = scene.lights[std::size_t(lights[i].light)];
        if (light.type != LightType::Directional || !isMixed(light)) continue;
        if (light.baking.occlusionMaskChannel == 0) return int(i);
        if (main < 0) main = int(i);
    }
    return main;
}

} // namespace

void selectLights(const BakedScene& baked, const FrameView& view, FramePlan& plan)
{
    const Scene& scene = baked.scene;
    const int mode = int(plan.mode);
    const bool usesBake = plan.mode != RunMode::Realtime && baked.isBaked;
    const bool subtractive = usesBake && plan.mode == RunMode::Subtractive;
    const Planes frustum = planesOf(view.clipFromView() * view.viewFromWorld());
    const vec3 cameraPosition = vec3(view.camera.worldFromCamera[3]);

    for (int i = 0; i < int(scene.lights.size()); ++i) {
        const Light& light = scene.lights[std::size_t(i)];
        if (usesBake) {
            const bool bakedShadows = shading::modeUsesBakedShadows(mode) && isMixed(light);
            for (std::string& sentence : changesSinceBake(light, nameOf(scene, i), bakedShadows))
                plan.warnings.push_back(std::move(sentence));
        }
        // S5: a baked light is wholly in lightmap and probes.
        if (usesBake && light.baking.isBaked && light.baking.bakeType == LightMode::Baked) continue;
        if (!(power(light) > 0.0f) || !meets(volumeOf(light), frustum)) continue;
        FrameLight frameLight;
        frameLight.light = i;
        frameLight.importance = importanceOf(light, cameraPosition);
        plan.lights.push_back(frameLight);
    }

    std::sort(plan.lights.begin(), plan.lights.end(),
              [&](const FrameLight& a, const FrameLight& b) { return before(scene, a, b); });
    if (plan.lights.size() > std::size_t(kMaxFrameLights)) {
        std::string names;
        for (std::size_t i = kMaxFrameLights; i < plan.lights.size(); ++i) {
            names += (names.empty() ? "" : ", ") + nameOf(scene, plan.lights[i].light);
        }
        plan.warnings.push_back("more than " + std::to_string(kMaxFrameLights) +
                                " lights are in view; left out: " + names);
        plan.lights.resize(kMaxFrameLights);
    }
    if (subtractive) plan.mainLight = findMainLight(scene, plan.lights);

    for (std::size_t i = 0; i < plan.lights.size(); ++i) {
        FrameLight& frameLight = plan.lights[i];
        const Light& light = scene.lights[std::size_t(frameLight.light)];
        const bool mixed = usesBake && isMixed(light);
        const bool inLightmap = subtractive && mixed; // direct light too (spec S6)
        // S18, S25: in subtractive mode only the main light is mixed with a baked shadow. A light whose shadows are off
        // has none of any kind.
        const bool throwsShadows = light.castShadows && light.shadowStrength > 0.0f;
        frameLight.hasBaked = mixed && throwsShadows && shading::modeUsesBakedShadows(mode) &&
                              light.baking.occlusionMaskChannel >= 0 && (!subtractive || int(i) == plan.mainLight);
        frameLight.channel = frameLight.hasBaked ? light.baking.occlusionMaskChannel : -1;
        frameLight.skipStatic = inLightmap;
        // Casters by spec section 2: "dynamic only, for lights that have a channel (or are fully baked for static)".
        // The second half is every mixed light of subtractive mode, the main light or not.
        frameLight.staticCasters = shading::staticCastersInShadowMap(mode, frameLight.hasBaked || inLightmap);
        plan.coloredMasks = plan.coloredMasks || (frameLight.hasBaked && light.baking.coloredMask);
        if (frameLight.hasBaked && !subtractive)
            plan.maskLayers = std::max(plan.maskLayers, frameLight.channel / kLayerChannels + 1);
        plan.usesMask = plan.maskLayers > 0;
    }
}

void addOverflowedLights(const BakedScene& baked, std::span<const Bounds> bounds, const FrameView& view,
                         FramePlan& plan)
{
    const Scene& scene = baked.scene;
    const Planes frustum = planesOf(view.clipFromView() * view.viewFromWorld());
    for (int i = 0; i < int(scene.lights.size()); ++i) {
        const Light& light = scene.lights[std::size_t(i)];
        if (!lostItsChannel(light) || !(power(light) > 0.0f) || !meets(volumeOf(light), frustum)) continue;
        if (plan.lights.size() == std::size_t(kMaxFrameLights)) break;
        FrameLight frameLight;
        frameLight.light = i;
        frameLight.skipStatic = true;
        frameLight.skipDynamic = true;
        frameLight.overflowed = true;
        frameLight.importance = importanceOf(light, vec3(view.camera.worldFromCamera[3]));
        plan.lights.push_back(frameLight);
    }
    Bounds sceneBounds;
    for (const Bounds& box : bounds) sceneBounds.extend(box);
    plan.clusters = clusterLights(scene, view, sceneBounds, plan.lights);
}

} // namespace halflight
