// Subtractive: its main light, and which objects receive its dynamic shadows (spec S21, S25, S27).
#include "plan_scene.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

namespace halflight::subtractive_test {
namespace {

using namespace test;

TEST(SubtractiveS21, MainLightIsTheBrightestMixedDirectional)
{
    BakedScene baked = stage(MixedLightingMode::Subtractive);
    baked.scene.lights = {
        bakedLight("dim", LightType::Directional, {}, {0, -1, 0.2f}, LightMode::Mixed, -1),
        bakedLight("bright", LightType::Directional, {}, {0, -1, 0.1f}, LightMode::Mixed, -1),
        bakedLight("realtime", LightType::Directional, {}, {0, -1, 0.3f}, LightMode::Realtime, -1),
        bakedLight("spot", LightType::Spot, {0, 5, 0}, {0, -1, 0}, LightMode::Mixed, -1),
    };
    baked.scene.lights[0].intensity = 10;
    baked.scene.lights[1].intensity = 1000;
    baked.scene.lights[2].intensity = 100000;
    baked.scene.lights[3].intensity = 100000;
    const FramePlan frame = plan(baked, stageView(), RunMode::Subtractive);
    ASSERT_GE(frame.mainLight, 0);
    EXPECT_EQ(frame.lights[std::size_t(frame.mainLight)].light, 1);
    EXPECT_FALSE(frame.lights[std::size_t(frame.mainLight)].hasBaked) << "no channel, no probe shadow";
    EXPECT_EQ(plan(baked, stageView(), RunMode::Realtime).mainLight, -1);
}

// S25 with S29: probes hold one light's attenuation in channel 0; dimming that light must not give its shadows to
// another.
TEST(SubtractiveS25, MainLightKeepsItsProbeChannelWhenDimmed)
{
    BakedScene baked = stage(MixedLightingMode::Subtractive);
    baked.scene.lights = {bakedLight("sun", LightType::Directional, {}, {0, -1, 0.2f}, LightMode::Mixed, 0),
                          bakedLight("moon", LightType::Directional, {}, {0, -1, 0.1f}, LightMode::Mixed, -1)};
    baked.scene.lights[0].intensity = 1;
    baked.scene.lights[1].intensity = 50;
    const FramePlan frame = plan(baked, stageView(), RunMode::Subtractive);
    ASSERT_GE(frame.mainLight, 0);
    const FrameLight& main = frame.lights[std::size_t(frame.mainLight)];
    EXPECT_EQ(main.light, 0);
    EXPECT_TRUE(main.hasBaked);
    EXPECT_EQ(main.channel, 0);
    EXPECT_FALSE(find(baked, frame, "moon")->hasBaked);
}

TEST(SubtractiveS25, OtherMixedLightsAreNotMixedEvenWithAChannel)
{
    BakedScene baked = stage(MixedLightingMode::Subtractive);
    baked.scene.lights = {bakedLight("sun", LightType::Directional, {}, {0, -1, 0.2f}, LightMode::Mixed, 0),
                          bakedLight("spot", LightType::Spot, {0, 5, 0}, {0, -1, 0}, LightMode::Mixed, 1)};
    const FramePlan frame = plan(baked, stageView(), RunMode::Subtractive);
    EXPECT_TRUE(find(baked, frame, "sun")->hasBaked);
    EXPECT_FALSE(find(baked, frame, "spot")->hasBaked);
    EXPECT_TRUE(find(baked, frame, "spot")->skipStatic);
}

// Static objects that no dynamic shadow can reach are no receivers, all others are: by brute force with rays from
// random points of the casters.
TEST(SubtractiveS27, ReceiversAreThoseThatDynamicShadowsReach)
{
    Random random(27);
    std::size_t found = 0;
    for (int round = 0; round < 20; ++round) {
        BakedScene baked = emptyScene(MixedLightingMode::Subtractive);
        for (int i = 0; i < 60; ++i)
            addBox(baked, random.in(vec3(-25, 0, -50), vec3(25, 8, 0)), random.in(vec3(0.2f), vec3(2.0f)), i % 12 != 0);
        const vec3 sun = glm::normalize(vec3(random.in(-1, 1), -1, random.in(-1, 1)));
        baked.scene.lights = {bakedLight("sun", LightType::Directional, {}, sun, LightMode::Mixed, 0)};
        const FrameView view = lookFrom({0, 4, 5}, {0, -0.1f, -1});
        ShadowSettings settings;
        settings.distanceMeters = 40.0f;
        const FramePlan frame = plan(baked, view, RunMode::Subtractive, settings);
        const std::vector<Bounds> bounds = objectBounds(baked.scene);
        ASSERT_EQ(frame.mainShadowReceivers.size(), bounds.size());
        const mat4 clipFromWorld = view.clipFromView() * view.viewFromWorld();
        for (std::size_t caster = 0; caster < bounds.size(); caster += 12) {
            for (int n = 0; n < 100; ++n) {
                const vec3 from = random.in(bounds[caster].min, bounds[caster].max);
                for (std::size_t i = 0; i < bounds.size(); ++i) {
                    // Where the ray enters the box (Kay and Kajiya 1986, slabs).
                    const vec3 a = (bounds[i].min - from) / sun;
                    const vec3 b = (bounds[i].max - from) / sun;
                    const vec3 low = glm::min(a, b);
                    const vec3 high = glm::max(a, b);
                    const float enter = std::max({low.x, low.y, low.z, 0.0f});
                    if (i == caster || enter > std::min({high.x, high.y, high.z})) continue;
                    const vec3 shadowed = from + enter * sun;
                    const vec4 clip = clipFromWorld * vec4(shadowed, 1.0f);
                    if (clip.w <= 0.0f || std::abs(clip.x) > clip.w || std::abs(clip.y) > clip.w) continue;
                    if (glm::distance(shadowed, vec3(0, 4, 5)) >= settings.distanceMeters) continue;
                    EXPECT_EQ(int(frame.mainShadowReceivers[i]), 1) << "round " << round << ", object " << i;
                }
            }
        }
        found += std::size_t(std::count(frame.mainShadowReceivers.begin(), frame.mainShadowReceivers.end(), 1));
    }
    EXPECT_GT(found, 50u);
    EXPECT_LT(found, 300u) << "of 1200: a receiver is an exception";
}

TEST(SubtractiveS27, NoReceiversWithoutAMapOfTheMainLight)
{
    BakedScene baked = stage(MixedLightingMode::Subtractive);
    baked.scene.lights = {bakedLight("sun", LightType::Directional, {}, {0, -1, 0.2f}, LightMode::Mixed, 0)};
    EXPECT_EQ(plan(baked, stageView(), RunMode::Subtractive).mainShadowReceivers, (std::vector<uint8_t>{1, 1}));
    EXPECT_TRUE(plan(baked, stageView(), RunMode::Realtime).mainShadowReceivers.empty());
    baked.scene.objects[1].castShadows = false;
    EXPECT_TRUE(plan(baked, stageView(), RunMode::Subtractive).mainShadowReceivers.empty());
}

} // namespace
} // namespace halflight::subtractive_test
