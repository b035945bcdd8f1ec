#include "halflight/shading/law.h"
#include "plan_scene.h"

#include <gtest/gtest.h>

namespace halflight::modes_test {
namespace {

using namespace test;

vec3 ndc(const FrameView& view, vec3 world)
{
    const vec4 clip = view.clipFromView() * view.viewFromWorld() * vec4(world, 1.0f);
    return vec3(clip) / clip.w;
}

TEST(FrameView, PerspectiveIsVulkanReversedZ)
{
    FrameView view = lookFrom({1, 2, 3}, {1, 0.2f, -0.4f}, {1600, 900});
    view.camera.nearMeters = 0.25f;
    view.camera.farMeters = 80.0f;
    EXPECT_NEAR(ndc(view, pointInView(view, {0.5f, 0.5f}, 0.25f)).z, 1.0f, 1e-5f);
    EXPECT_NEAR(ndc(view, pointInView(view, {0.5f, 0.5f}, 80.0f)).z, 0.0f, 1e-5f);
    // Depth is linear in 1/z between the two.
    EXPECT_NEAR(ndc(view, pointInView(view, {0.5f, 0.5f}, 2.0f)).z, (1 / 2.0f - 1 / 80.0f) / (1 / 0.25f - 1 / 80.0f),
                1e-5f);
    const vec3 topLeft = ndc(view, pointInView(view, {0.0f, 0.0f}, 10.0f));
    EXPECT_NEAR(topLeft.x, -1.0f, 1e-4f);
    EXPECT_NEAR(topLeft.y, -1.0f, 1e-4f) << "Vulkan's y points down";
}

TEST(FrameView, InfiniteFarPlane)
{
    FrameView view = lookFrom({0, 0, 0}, {0, 0, -1});
    view.camera.farMeters = kInfinity;
    EXPECT_NEAR(ndc(view, {0, 0, -view.camera.nearMeters}).z, 1.0f, 1e-6f);
    EXPECT_GT(ndc(view, {0, 0, -1e6f}).z, 0.0f);
    // Planning works with it too: lights behind are out, lights ahead are in.
    BakedScene baked = emptyScene();
    baked.scene.lights = {bakedLight("ahead", LightType::Point, {0, 0, -500}, {0, 0, -1}, LightMode::Realtime, -1),
                          bakedLight("behind", LightType::Point, {0, 0, 50}, {0, 0, -1}, LightMode::Realtime, -1)};
    for (Light& light : baked.scene.lights) light.rangeMeters = 5.0f;
    const FramePlan frame = plan(baked, view, RunMode::Realtime);
    EXPECT_NE(find(baked, frame, "ahead"), nullptr);
    EXPECT_EQ(find(baked, frame, "behind"), nullptr);
}

TEST(FrameView, OrthographicIsVulkanReversedZ)
{
    FrameView view = lookFrom({-3, 1, 2}, {0.3f, -1, 0.1f}, {400, 300});
    view.camera.orthographic = true;
    view.camera.orthographicHeightMeters = 6.0f;
    view.camera.nearMeters = 1.0f;
    view.camera.farMeters = 21.0f;
    EXPECT_NEAR(ndc(view, pointInView(view, {0.5f, 0.5f}, 1.0f)).z, 1.0f, 1e-5f);
    EXPECT_NEAR(ndc(view, pointInView(view, {0.5f, 0.5f}, 11.0f)).z, 0.5f, 1e-5f);
    EXPECT_NEAR(ndc(view, pointInView(view, {0.5f, 0.5f}, 21.0f)).z, 0.0f, 1e-5f);
    const vec3 corner = ndc(view, pointInView(view, {1.0f, 1.0f}, 5.0f));
    EXPECT_NEAR(corner.x, 1.0f, 1e-5f);
    EXPECT_NEAR(corner.y, 1.0f, 1e-5f);
}

TEST(RunModes, EachBakeFitsItsModes)
{
    using enum RunMode;
    const struct {
        bool isBaked;
        MixedLightingMode bake;
        RunMode standard;
        bool fits[5]; // by RunMode
    } table[] = {
        {false, MixedLightingMode::Shadowmask, Realtime, {true, false, false, false, false}},
        {true, MixedLightingMode::BakedIndirect, BakedIndirect, {true, true, false, false, false}},
        {true, MixedLightingMode::Shadowmask, Shadowmask, {true, true, true, true, false}},
        {true, MixedLightingMode::Subtractive, Subtractive, {true, false, false, false, true}},
    };
    for (const auto& row : table) {
        BakedScene baked = emptyScene(row.bake);
        baked.isBaked = row.isBaked;
        EXPECT_EQ(defaultRunMode(baked), row.standard);
        for (int mode = 0; mode < 5; ++mode) {
            const Status status = checkRunMode(baked, RunMode(mode));
            EXPECT_EQ(bool(status), row.fits[mode]) << "bake " << int(row.bake) << " mode " << mode;
            if (!status) {
                EXPECT_EQ(status.error().code, ErrorCode::InvalidArgument);
                EXPECT_FALSE(status.error().message.empty());
            }
        }
    }
}

TEST(RunModes, ChannelsWithoutPagesAreRefused)
{
    BakedScene baked = emptyScene();
    baked.scene.lights = {bakedLight("sun", LightType::Directional, {}, {0, -1, 0}, LightMode::Mixed, 0)};
    baked.lightmaps.emplace_back(4, 4);
    EXPECT_FALSE(checkRunMode(baked, RunMode::Shadowmask));
    EXPECT_FALSE(checkRunMode(baked, RunMode::DistanceShadowmask));
    EXPECT_TRUE(checkRunMode(baked, RunMode::BakedIndirect)) << "needs no mask";
    baked.shadowmasks.emplace_back(4, 4);
    EXPECT_TRUE(checkRunMode(baked, RunMode::Shadowmask));
}

TEST(ShadowSettingsS1, LimitsAndDefaults)
{
    EXPECT_TRUE(checkShadowSettings({}));
    EXPECT_GE(ShadowSettings{}.distanceMeters, 50.0f);
    EXPECT_LE(ShadowSettings{}.distanceMeters, 100.0f);
    EXPECT_EQ(ShadowSettings{}.fadeRangeMeters, 1.0f);
    const auto refused = [](auto change) {
        ShadowSettings settings;
        change(settings);
        const Status status = checkShadowSettings(settings);
        return !status && status.error().code == ErrorCode::InvalidArgument;
    };
    const float nan = std::numeric_limits<float>::quiet_NaN();
    EXPECT_TRUE(refused([](auto& s) { s.distanceMeters = 0.0f; }));
    EXPECT_TRUE(refused([&](auto& s) { s.distanceMeters = nan; }));
    EXPECT_TRUE(refused([](auto& s) { s.distanceMeters = kInfinity; }));
    EXPECT_TRUE(refused([](auto& s) { s.fadeRangeMeters = 0.009f; }));
    EXPECT_TRUE(refused([&](auto& s) { s.fadeRangeMeters = nan; }));
    EXPECT_FALSE(refused([](auto& s) { s.fadeRangeMeters = 0.01f; }));
    EXPECT_TRUE(refused([](auto& s) { s.cascades = 0; }));
    EXPECT_TRUE(refused([](auto& s) { s.cascades = 5; }));
    EXPECT_TRUE(refused([](auto& s) { s.cascadeSplitLambda = 1.1f; }));
    EXPECT_TRUE(refused([](auto& s) { s.cascadeBlendFraction = 0.6f; }));
    EXPECT_TRUE(refused([](auto& s) { s.directionalMapSize = 32; }));
    EXPECT_TRUE(refused([](auto& s) { s.atlasSize = 1 << 20; }));
    EXPECT_TRUE(refused([&](auto& s) { s.slopeBias = nan; }));
    EXPECT_TRUE(refused([](auto& s) { s.normalBiasTexels = -1.0f; }));
}

TEST(ShadowSettingsS1, PlanCarriesFadeConstants)
{
    ShadowSettings settings;
    settings.distanceMeters = 40.0f;
    settings.fadeRangeMeters = 5.0f;
    const FramePlan frame = plan(emptyScene(), lookFrom({}, {0, 0, -1}), RunMode::Realtime, settings);
    for (const float c : {0.0f, 10.0f, 35.0f, 36.0f, 37.5f, 39.9f, 40.0f, 41.0f, 1000.0f}) {
        const float truth = std::clamp((c - 40.0f) / 5.0f + 1.0f, 0.0f, 1.0f);
        EXPECT_NEAR(std::clamp(c * frame.fadeConstants.x + frame.fadeConstants.y, 0.0f, 1.0f), truth, 1e-5f) << c;
    }
}

} // namespace
} // namespace halflight::modes_test
