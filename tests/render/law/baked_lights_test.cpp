// Spot and point lights with masks, several masked lights at once.
#include "render/law_scene.h"

#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/packing.hpp>

#include <algorithm>
#include <array>

namespace halflight::test::baked_lights_test {
namespace {

constexpr ivec2 kSize{256, 144};
const vec3 kAlbedo(0.6f);

/// A 20 m floor whose mask is (51, 102, 153, 204) / 255 where x > 0 and lit where x < 0; a dynamic slab throws a shadow
/// on z > 0 from lights above.
struct MaskedFloor {
    BakedScene baked;
    Camera camera = lookAt(vec3(0, 9, 0.01f), vec3(0, 0, 0), kPi / 3.0f);

    MaskedFloor()
    {
        Scene& scene = baked.scene;
        baked.isBaked = true;
        const int material = addMaterial(scene, vec4(kAlbedo, 1.0f));
        addObject(scene, makeRectangle(20, 20, material), mat4(1.0f), true);
        scene.objects[0].lightmap = {0, vec2(1.0f), vec2(0.0f)};
        baked.lightmaps.emplace_back(64, 64, uint32_t(0));
        ImageRgba8 mask(64, 64, u8vec4(255));
        for (int y = 0; y < 64; ++y)
            for (int x = 32; x < 64; ++x) mask(x, y) = u8vec4(51, 102, 153, 204);
        baked.shadowmasks.push_back(mask);
    }
    /// 4 m wide in x, from z = 1 to z = 3, at height 1: dynamic.
    void addBlocker()
    {
        addObject(baked.scene, makeRectangle(8, 2, 0), glm::translate(mat4(1.0f), vec3(0, 1, 2)), false);
    }
    int addLight(LightType type, vec3 position, vec3 direction, float intensity, int channel)
    {
        Light light;
        light.type = type;
        light.worldFromLight = lightPose(position, direction);
        light.intensity = intensity;
        light.rangeMeters = type == LightType::Directional ? 0.0f : 20.0f;
        light.innerConeRadians = 0.6f;
        light.outerConeRadians = 0.8f;
        bakeAsMixed(light, MixedLightingMode::Shadowmask, channel);
        baked.scene.lights.push_back(light);
        return int(baked.scene.lights.size()) - 1;
    }
    [[nodiscard]] ShadedPoint pointAt(vec3 near, ivec2& pixel) const
    {
        pixel = pixelOf(camera, kSize, near);
        const Ray ray = pixelRay(camera, kSize, pixel);
        return {onPlane(ray, 0.0f), vec3(0, 1, 0), -ray.direction, kAlbedo};
    }
};

RenderSettings settingsFor(RenderPath path, RunMode mode)
{
    RenderSettings settings;
    settings.path = path;
    settings.mode = mode;
    settings.size = kSize;
    settings.shadows.atlasSize = 2048;
    return settings;
}

constexpr float kMask[4] = {51 / 255.0f, 102 / 255.0f, 153 / 255.0f, 204 / 255.0f};

/// Where the light's shadow of the blocker falls: a point of the floor under its middle, seen from the light.
vec3 umbra(vec3 light, float x)
{
    const vec3 onSlab(x * (light.y - 1.0f) / light.y, 1.0f, 2.0f);
    return light + (onSlab - light) * (light.y / (light.y - 1.0f));
}

class LocalMask : public RenderTest, public testing::WithParamInterface<std::tuple<LightType, RunMode, RenderPath>> {};

// The camera sees the slab over the umbra, so it looks from below the slab's height in these tests: the slab is thin
// and the umbra's far end is checked, beyond the slab as the camera sees it.
TEST_P(LocalMask, RealtimeAndBakedMeetS3S4S8)
{
    const auto [type, mode, path] = GetParam();
    MaskedFloor floor;
    const vec3 position(0, 4, 0);
    floor.addLight(type, position, type == LightType::Spot ? vec3(0, -1, 0.3f) : vec3(0, -1, 0), 50.0f, 1);
    floor.addBlocker();
    floor.camera = lookAt(vec3(0, 0.8f, 9), vec3(0, 0, 2), kPi / 3.0f);
    const RenderedFrame frame = render(floor.baked, floor.camera, settingsFor(path, mode));
    ASSERT_EQ(frame.plan.lights.size(), 1u);
    EXPECT_TRUE(frame.plan.lights[0].hasRealtimeShadow);
    const Light& light = floor.baked.scene.lights[0];
    for (const float x : {-0.8f, 0.8f}) {
        for (const bool shadowed : {true, false}) {
            ivec2 pixel;
            const ShadedPoint point = floor.pointAt(shadowed ? umbra(position, x) : vec3(x, 0, 0.5f), pixel);
            const float attenuation =
                law::attenuationByHand(mode, true, x > 0 ? kMask[1] : 1.0f, true, shadowed ? 0.0f : 1.0f, 0.0f, 1.0f);
            EXPECT_TRUE(near(vec3(frame.radiance(pixel.x, pixel.y)), directRadiance(point, light, attenuation)))
                << "x " << x << " shadowed " << shadowed << " pixel " << pixel.x << ' ' << pixel.y;
        }
    }
}
INSTANTIATE_TEST_SUITE_P(, LocalMask,
                         testing::Combine(testing::Values(LightType::Spot, LightType::Point),
                                          testing::Values(RunMode::Shadowmask, RunMode::DistanceShadowmask),
                                          kBothPaths));

class BakedLights : public BothPaths {};
INSTANTIATE_TEST_SUITE_P(, BakedLights, kBothPaths, pathNameOf);

// S4. A point light without realtime map: the mask at every distance, and the dynamic slab throws no shadow.
TEST_P(BakedLights, PointLightWithoutMapUsesMaskS4)
{
    for (const RunMode mode : {RunMode::Shadowmask, RunMode::DistanceShadowmask}) {
        MaskedFloor floor;
        floor.addLight(LightType::Point, vec3(0, 4, 0), vec3(0, -1, 0), 50.0f, 2);
        floor.addBlocker();
        floor.camera = lookAt(vec3(0, 0.8f, 9), vec3(0, 0, 2), kPi / 3.0f);
        RenderSettings settings = settingsFor(GetParam(), mode);
        settings.shadows.pointShadows = false;
        const RenderedFrame frame = render(floor.baked, floor.camera, settings);
        for (const float x : {-0.8f, 0.8f}) {
            ivec2 pixel;
            const ShadedPoint point = floor.pointAt(umbra(vec3(0, 4, 0), x), pixel);
            EXPECT_TRUE(near(vec3(frame.radiance(pixel.x, pixel.y)),
                             directRadiance(point, floor.baked.scene.lights[0], x > 0 ? kMask[2] : 1.0f)));
        }
    }
}

// S18, S28. Four masked lights of all kinds at once: each takes its own channel, whatever the lights' order.
TEST_P(BakedLights, FourMasksByChannelS18S28)
{
    for (const bool reversed : {false, true}) {
        MaskedFloor floor;
        floor.addLight(LightType::Directional, vec3(0.0f), vec3(0.3f, -1, 0.1f), 2.0f, 3);
        floor.addLight(LightType::Spot, vec3(1, 5, -1), vec3(0, -1, 0), 60.0f, 0);
        floor.addLight(LightType::Directional, vec3(0.0f), vec3(-0.2f, -1, 0.4f), 3.0f, 1);
        floor.addLight(LightType::Point, vec3(-1, 3, 1), vec3(0, -1, 0), 20.0f, 2);
        auto& lights = floor.baked.scene.lights;
        if (reversed) std::reverse(lights.begin(), lights.end());
        for (const RunMode mode : {RunMode::Shadowmask, RunMode::DistanceShadowmask}) {
            // Without casters: by the law every light has A = B.
            floor.baked.scene.objects[0].castShadows = false;
            const RenderedFrame frame = render(floor.baked, floor.camera, settingsFor(GetParam(), mode));
            EXPECT_EQ(frame.plan.lights.size(), 4u);
            for (const vec3 near : {vec3(-1.5f, 0, 0.5f), vec3(1.5f, 0, 0.5f), vec3(2, 0, -1), vec3(-2, 0, -1)}) {
                ivec2 pixel;
                const ShadedPoint point = floor.pointAt(near, pixel);
                vec3 expected(0.0f);
                for (const Light& light : lights)
                    expected += directRadiance(point, light,
                                               point.position.x > 0 ? kMask[light.baking.occlusionMaskChannel] : 1.0f);
                EXPECT_TRUE(test::near(vec3(frame.radiance(pixel.x, pixel.y)), expected)) << near.x << ' ' << near.z;
            }
        }
    }
}

// S18. The same with shadow maps for all four, near, within the fade and beyond: R is 1 where no caster stands, so
// shadowmask mode shows min(F, B) = B everywhere, distance shadowmask goes from lit to B.
TEST_P(BakedLights, FourMasksInTheFadeS18)
{
    for (const RunMode mode : {RunMode::Shadowmask, RunMode::DistanceShadowmask}) {
        for (const float distance : {40.0f, 12.0f, 10.0f, 5.0f}) {
            MaskedFloor floor;
            floor.addLight(LightType::Directional, vec3(0.0f), vec3(0.3f, -1, 0.1f), 2.0f, 3);
            floor.addLight(LightType::Spot, vec3(1, 5, -1), vec3(0, -1, 0), 60.0f, 0);
            floor.addLight(LightType::Directional, vec3(0.0f), vec3(-0.2f, -1, 0.4f), 3.0f, 1);
            floor.addLight(LightType::Point, vec3(-1, 3, 1), vec3(0, -1, 0), 20.0f, 2);
            // A small plate right under the point light, in reach of all; its shadows fall beside the places below.
            addObject(floor.baked.scene, makeRectangle(0.1f, 0.1f, 0), glm::translate(mat4(1.0f), vec3(-0.5f, 0.5f, 0)),
                      false);
            RenderSettings settings = settingsFor(GetParam(), mode);
            settings.shadows.distanceMeters = distance;
            settings.shadows.fadeRangeMeters = 4.0f;
            const RenderedFrame frame = render(floor.baked, floor.camera, settings);
            if (distance >= 10.0f) // beyond, the plate is farther than any cascade reaches
                for (const FrameLight& light : frame.plan.lights) EXPECT_TRUE(light.hasRealtimeShadow);
            for (const vec3 near : {vec3(-1.5f, 0, 0.5f), vec3(1.5f, 0, 0.5f), vec3(2, 0, -1), vec3(-2, 0, -1)}) {
                ivec2 pixel;
                const ShadedPoint point = floor.pointAt(near, pixel);
                const float t =
                    glm::clamp((glm::distance(point.position, vec3(0, 9, 0.01f)) - distance) / 4.0f + 1.0f, 0.0f, 1.0f);
                vec3 expected(0.0f);
                for (const Light& light : floor.baked.scene.lights) {
                    const float baked = point.position.x > 0 ? kMask[light.baking.occlusionMaskChannel] : 1.0f;
                    const float attenuation = mode == RunMode::Shadowmask ? baked : 1.0f - t + t * baked;
                    expected += directRadiance(point, light, attenuation);
                }
                EXPECT_TRUE(test::near(vec3(frame.radiance(pixel.x, pixel.y)), expected, 2.0e-3f))
                    << near.x << ' ' << near.z << " t " << t;
            }
        }
    }
}

// S28. Two masked directional lights, each with its own shadow of a dynamic caster, its own mask and the common fade.
TEST_P(BakedLights, TwoDirectionalLightsWithShadowsS28)
{
    const vec3 toA = glm::normalize(vec3(0.8f, 1, 0));
    const vec3 toB = glm::normalize(vec3(-0.5f, 1, 0)); // no mirror image of the other: each needs its own map
    for (const RunMode mode : {RunMode::Shadowmask, RunMode::DistanceShadowmask}) {
        MaskedFloor floor;
        floor.addLight(LightType::Directional, vec3(0.0f), -toA, 2.0f, 0);
        floor.addLight(LightType::Directional, vec3(0.0f), -toB, 5.0f, 3);
        // A slab 6 m up: its shadows lie 4.8 m to the left and 3 m to the right, on the two halves of the floor.
        addObject(floor.baked.scene, makeRectangle(2, 2, 0), glm::translate(mat4(1.0f), vec3(0, 6, 0)), false);
        floor.camera = lookAt(vec3(0, 5, 11), vec3(0, 0, 0), kPi / 2.0f);
        const auto& lights = floor.baked.scene.lights;
        int bands[3] = {0, 0, 0};
        for (const float shadowDistance : {40.0f, 14.0f, 9.0f}) {
            RenderSettings settings = settingsFor(GetParam(), mode);
            settings.shadows.distanceMeters = shadowDistance;
            settings.shadows.fadeRangeMeters = 6.0f;
            const RenderedFrame frame = render(floor.baked, floor.camera, settings);
            for (int n = 0; n < 20 * 10; ++n) { // all over the floor, but for the edges of mask and shadows
                ivec2 pixel;
                const ShadedPoint point =
                    floor.pointAt(vec3(0.65f * (float(n % 20) - 9.5f), 0, 0.6f * float(n / 20) - 3.0f), pixel);
                const float x = point.position.x;
                const auto beside = [&](float center) { // how far from the edge of a shadow, inside below 0
                    return std::max(std::abs(x - center), std::abs(point.position.z)) - 1.0f;
                };
                if (std::abs(x) < 0.3f || std::min(std::abs(beside(-4.8f)), std::abs(beside(3.0f))) < 0.3f) continue;
                const float distance = glm::distance(point.position, vec3(0, 5, 11));
                const float fade = glm::clamp((distance - shadowDistance) / 6.0f + 1.0f, 0.0f, 1.0f);
                bands[fade == 0.0f ? 0 : fade == 1.0f ? 2 : 1]++;
                vec3 expected(0.0f);
                for (int i = 0; i < 2; ++i) {
                    const float realtime = beside(i == 0 ? -4.8f : 3.0f) < 0.0f ? 0.0f : 1.0f;
                    const float baked = x > 0 ? kMask[i == 0 ? 0 : 3] : 1.0f;
                    expected += directRadiance(point, lights[std::size_t(i)],
                                               law::attenuationByHand(mode, true, baked, true, realtime, fade, 1.0f));
                }
                EXPECT_TRUE(near(vec3(frame.radiance(pixel.x, pixel.y)), expected)) << x << " t " << fade;
            }
        }
        EXPECT_TRUE(bands[0] > 100 && bands[1] > 100 && bands[2] > 100) << "near, within the fade, beyond";
    }
}

// S29. Colour and intensity changed at run time: baked shadows stay what they were, in proportion.
TEST_P(BakedLights, IntensityChangesKeepBakedShadowsS29)
{
    MaskedFloor floor;
    floor.addLight(LightType::Spot, vec3(0, 5, 0), vec3(0, -1, 0), 60.0f, 0);
    ivec2 pixel;
    const ShadedPoint point = floor.pointAt(vec3(1, 0, 0), pixel);
    Light& light = floor.baked.scene.lights[0];
    for (const float factor : {1.0f, 4.0f}) {
        light.intensity = 60.0f * factor;
        light.color = vec3(1.0f, 0.5f, 0.25f) * factor;
        const RenderedFrame frame = render(floor.baked, floor.camera, settingsFor(GetParam(), RunMode::Shadowmask));
        EXPECT_TRUE(near(vec3(frame.radiance(pixel.x, pixel.y)), directRadiance(point, light, kMask[0])));
        EXPECT_TRUE(frame.plan.warnings.empty());
    }
}

// S11. A realtime light in a masked scene is untouched by others' masks.
TEST_P(BakedLights, RealtimeLightIgnoresMasksS11)
{
    MaskedFloor floor;
    floor.addLight(LightType::Spot, vec3(0, 5, 0), vec3(0, -1, 0), 60.0f, 0);
    floor.addLight(LightType::Spot, vec3(1, 5, 1), vec3(0, -1, 0), 30.0f, -1);
    floor.baked.scene.lights[1].baking = {};
    floor.baked.scene.lights[1].mode = LightMode::Realtime;
    const RenderedFrame frame = render(floor.baked, floor.camera, settingsFor(GetParam(), RunMode::Shadowmask));
    ivec2 pixel;
    const ShadedPoint point = floor.pointAt(vec3(1, 0, 0), pixel);
    EXPECT_TRUE(
        near(vec3(frame.radiance(pixel.x, pixel.y)), directRadiance(point, floor.baked.scene.lights[0], kMask[0]) +
                                                         directRadiance(point, floor.baked.scene.lights[1], 1.0f)));
}

} // namespace
} // namespace halflight::test::baked_lights_test
