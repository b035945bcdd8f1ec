#pragma once
// A light above two plates over a floor, and the law's attenuation at places of the floor.
#include "render/law_scene.h"

#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/packing.hpp>

namespace halflight::test::plates {

inline constexpr ivec2 kSize{256, 144};
inline const vec3 kAlbedo(0.6f, 0.5f, 0.4f);
inline constexpr float kMask = 0.4f; // 102 / 255
inline constexpr float kHeight = 4.0f;
inline constexpr float kIrradiance = 0.25f; ///< of the lightmap
inline constexpr float kFadeRange = 3.0f;

/// Of the floor in front of the plates, as the camera sees them: in the dynamic plate's shadow left and right, in the
/// static plate's, and lit left and right.
struct Place {
    vec3 point;
    bool inDynamic;
    bool inStatic;
};
inline const Place kPlaces[] = {{{-0.8f, 0, 3.6f}, true, false},
                                {{0.8f, 0, 3.6f}, true, false},
                                {{2.7f, 0, 3.6f}, false, true},
                                {{-1.5f, 0, 4.5f}, false, false},
                                {{0.9f, 0, 4.5f}, false, false}};

/// The floor is masked where x > 0 for the light's channel 1 and otherwise lit. The light is kHeight up. A dynamic
/// plate is 1 m up on both sides of x = 0, and a static one beside it, whose shadow the mask does not know.
struct PlateScene {
    BakedScene baked;
    vec3 eye{0, 0.8f, 9};
    Camera camera = lookAt(eye, vec3(0, 0, 2), kPi / 3.0f);

    explicit PlateScene(const Light& light)
    {
        baked.isBaked = true;
        Scene& scene = baked.scene;
        const int material = addMaterial(scene, vec4(kAlbedo, 1.0f));
        addObject(scene, makeRectangle(20, 20, material), mat4(1.0f), true);
        scene.objects[0].lightmap = {0, vec2(1.0f), vec2(0.0f)};
        baked.lightmaps.emplace_back(64, 64, glm::packF3x9_E1x5(vec3(kIrradiance)));
        ImageRgba8 mask(64, 64, u8vec4(255));
        for (int y = 0; y < 64; ++y)
            for (int x = 32; x < 64; ++x) mask(x, y) = u8vec4(0, 102, 0, 0);
        baked.shadowmasks.push_back(mask);
        // From z = 1 to z = 3 at height 1; the shadows from the light's middle end at z = 4.
        addObject(scene, makeRectangle(2.4f, 2, material), glm::translate(mat4(1.0f), vec3(0, 1, 2)), false);
        addObject(scene, makeRectangle(1.0f, 2, material), glm::translate(mat4(1.0f), vec3(2.0f, 1, 2)), true);
        scene.lights.push_back(light);
        bakeAsMixed(scene.lights[0], MixedLightingMode::Shadowmask, 1);
    }
    [[nodiscard]] ShadedPoint pointAt(vec3 near, ivec2& pixel) const
    {
        pixel = pixelOf(camera, kSize, near);
        const Ray ray = pixelRay(camera, kSize, pixel);
        return {onPlane(ray, 0.0f), vec3(0, 1, 0), -ray.direction, kAlbedo};
    }
    [[nodiscard]] float fadeAt(vec3 point, float shadowDistance) const
    {
        return glm::clamp((glm::distance(eye, point) - shadowDistance) / kFadeRange + 1.0f, 0.0f, 1.0f);
    }
    /// By hand, with the light's shadows in a map.
    [[nodiscard]] float attenuationAt(const Place& place, vec3 point, RunMode mode, float shadowDistance) const
    {
        const bool masked = mode == RunMode::Shadowmask || mode == RunMode::DistanceShadowmask;
        const bool shadowed = place.inDynamic || (place.inStatic && mode != RunMode::Shadowmask);
        return law::attenuationByHand(mode, masked, point.x > 0.0f ? kMask : 1.0f, true, shadowed ? 0.0f : 1.0f,
                                      fadeAt(point, shadowDistance), baked.scene.lights[0].shadowStrength);
    }
};

using TypePath = std::tuple<LightType, RenderPath>;
inline std::string typePathName(const testing::TestParamInfo<TypePath>& info)
{
    std::string name = nameOf(std::get<0>(info.param));
    name[0] = char(name[0] - 'a' + 'A');
    return name + pathName(std::get<1>(info.param));
}

inline RenderSettings settingsFor(RunMode mode, const TypePath& param, const ShadowSettings& shadows)
{
    RenderSettings settings;
    settings.mode = mode;
    settings.path = std::get<1>(param);
    settings.size = kSize;
    settings.shadows = shadows;
    settings.shadows.fadeRangeMeters = kFadeRange;
    settings.shadows.atlasSize = 2048;
    return settings;
}

} // namespace halflight::test::plates
