// A row for each light of the scene: what the frame does with it, and why not more (spec section 4, frame debugger).
// Also what lights have of their own: biases, and what the frame says of changes since the bake (S29).
#include "plan_scene.h"
#include "render/frame/frame_internal.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace halflight::light_rows_test {
namespace {

using namespace test;
using testing::HasSubstr;
using testing::IsEmpty;

/// A floor, a dynamic box above it, and a camera that sees both.
BakedScene stage(MixedLightingMode mode = MixedLightingMode::Shadowmask)
{
    BakedScene baked = emptyScene(mode);
    addBox(baked, {0, -0.5f, 0}, {20, 0.5f, 20}, true);
    addBox(baked, {0, 1, 0}, {0.5f, 0.5f, 0.5f}, false);
    return baked;
}
FrameView stageView()
{
    return lookFrom({0, 4, 12}, {0, -0.3f, -1});
}

Light lamp(LightMode mode = LightMode::Mixed, int channel = 0, LightType type = LightType::Spot)
{
    return bakedLight("lamp", type, {0, 4, 0}, {0, -1, 0.01f}, mode, channel);
}

LightRow rowOf(const BakedScene& baked, RunMode mode, const ShadowSettings& shadows = {})
{
    const FramePlan frame = plan(baked, stageView(), mode, shadows);
    const std::vector<LightRow> rows = lightRows(baked, stageView(), frame);
    EXPECT_EQ(rows.size(), baked.scene.lights.size());
    return rows.at(0);
}

TEST(LightRows, ALightWithBothShadows)
{
    BakedScene baked = stage();
    baked.scene.lights = {lamp()};
    const LightRow masked = rowOf(baked, RunMode::Shadowmask);
    EXPECT_EQ(masked.frameLight, 0);
    EXPECT_EQ(masked.bakedChannel, 0);
    EXPECT_TRUE(masked.realtimeShadow);
    EXPECT_EQ(masked.noRealtimeShadow + masked.noBakedShadow + masked.notInFrame, "");
    EXPECT_EQ(masked.tiles, 1);
    EXPECT_EQ(masked.cascades, 0);
    EXPECT_GE(masked.tileTexels, 64);
    EXPECT_EQ(masked.staticCasters, 0) << "the floor is in the mask";
    EXPECT_EQ(masked.dynamicCasters, 1);
    const LightRow distance = rowOf(baked, RunMode::DistanceShadowmask);
    EXPECT_EQ(distance.staticCasters, 1);
    EXPECT_EQ(distance.dynamicCasters, 1);

    baked.scene.lights = {lamp(LightMode::Mixed, 2, LightType::Point)};
    EXPECT_EQ(rowOf(baked, RunMode::Shadowmask).tiles, 6);
    EXPECT_EQ(rowOf(baked, RunMode::Shadowmask).dynamicCasters, 1) << "an object counts once, in however many tiles";
    baked.scene.lights = {lamp(LightMode::Mixed, 3, LightType::Directional)};
    ShadowSettings three;
    three.cascades = 3;
    const LightRow sun = rowOf(baked, RunMode::Shadowmask, three);
    EXPECT_EQ(sun.cascades, 3);
    EXPECT_EQ(sun.tiles, 0);
    EXPECT_EQ(sun.tileTexels, three.directionalMapSize);
}

TEST(LightRows, EveryReasonWhyALightHasNoRealtimeShadow)
{
    const auto reason = [](const std::function<void(BakedScene&, ShadowSettings&)>& change,
                           RunMode mode = RunMode::DistanceShadowmask) {
        BakedScene baked = stage();
        baked.scene.lights = {lamp()};
        ShadowSettings settings;
        change(baked, settings);
        const LightRow row = rowOf(baked, mode, settings);
        EXPECT_EQ(row.realtimeShadow, row.noRealtimeShadow.empty());
        EXPECT_EQ(row.tiles + row.cascades > 0, row.realtimeShadow);
        return row.noRealtimeShadow;
    };
    EXPECT_EQ(reason([](BakedScene&, ShadowSettings&) {}), "");
    EXPECT_THAT(reason([](BakedScene& b, ShadowSettings&) { b.scene.lights[0].castShadows = false; }),
                HasSubstr("shadows are off"));
    EXPECT_THAT(reason([](BakedScene& b, ShadowSettings&) { b.scene.lights[0].shadowStrength = 0.0f; }),
                HasSubstr("strength is 0"));
    EXPECT_THAT(reason([](BakedScene& b, ShadowSettings& s) {
                    b.scene.lights = {lamp(LightMode::Mixed, 0, LightType::Point)};
                    s.pointShadows = false;
                }),
                HasSubstr("point lights are off"));
    EXPECT_THAT(reason([](BakedScene& b, ShadowSettings& s) {
                    b.scene.lights[0].rangeMeters = 5.0f;
                    s.distanceMeters = 2.0f;
                }),
                HasSubstr("beyond the shadow distance"));
    EXPECT_THAT(
        reason([](BakedScene& b, ShadowSettings&) { b.scene.objects[1].castShadows = false; }, RunMode::Shadowmask),
        HasSubstr("no caster"));
    EXPECT_THAT(reason([](BakedScene& b, ShadowSettings& s) {
                    // More spots than an atlas of 256 texels has places of 64 for.
                    for (int i = 0; i < 40; ++i) {
                        b.scene.lights.push_back(lamp());
                        b.scene.lights.back().intensity = 1.0e4f;
                    }
                    s.atlasSize = 256;
                }),
                HasSubstr("atlas is full"));
    EXPECT_THAT(reason([](BakedScene& b, ShadowSettings&) {
                    b.scene.lights = {lamp(LightMode::Mixed, 0, LightType::Directional)};
                    for (int i = 0; i < 4; ++i) {
                        b.scene.lights.push_back(lamp(LightMode::Realtime, -1, LightType::Directional));
                        b.scene.lights.back().intensity = 1.0e4f;
                    }
                }),
                HasSubstr("4 brighter directional lights"));
}

TEST(LightRows, EveryReasonWhyALightHasNoBakedShadowOrIsNotThere)
{
    BakedScene baked = stage();
    baked.scene.lights = {lamp()};
    EXPECT_THAT(rowOf(baked, RunMode::BakedIndirect).noBakedShadow, HasSubstr("mode reads no"));
    baked.isBaked = false;
    EXPECT_THAT(rowOf(baked, RunMode::Realtime).noBakedShadow, HasSubstr("not baked"));
    baked.isBaked = true;
    baked.scene.lights = {lamp(LightMode::Realtime, -1)};
    EXPECT_THAT(rowOf(baked, RunMode::Shadowmask).noBakedShadow, HasSubstr("realtime light"));
    baked.scene.lights = {lamp(LightMode::Mixed, -1)};
    EXPECT_THAT(rowOf(baked, RunMode::Shadowmask).noBakedShadow, HasSubstr("no shadowmask channel"));
    baked.scene.lights = {lamp(LightMode::Baked, -1)};
    EXPECT_EQ(rowOf(baked, RunMode::Shadowmask).notInFrame, "fully baked");
    EXPECT_EQ(rowOf(baked, RunMode::Realtime).notInFrame, "") << "it shines there";
    baked.scene.lights[0].mode = LightMode::Mixed;
    EXPECT_THAT(rowOf(baked, RunMode::Shadowmask).notInFrame, HasSubstr("no shadowmask channel was left"));
    baked.scene.lights = {lamp()};
    baked.scene.lights[0].intensity = 0.0f;
    EXPECT_THAT(rowOf(baked, RunMode::Shadowmask).notInFrame, HasSubstr("intensity is 0"));
    baked.scene.lights = {lamp()};
    baked.scene.lights[0].rangeMeters = 3.0f;
    baked.scene.lights[0].worldFromLight[3].z = 50.0f;
    EXPECT_EQ(rowOf(baked, RunMode::Realtime).notInFrame, "out of view");
    BakedScene subtractive = stage(MixedLightingMode::Subtractive);
    subtractive.scene.lights = {lamp(LightMode::Mixed, -1)};
    EXPECT_THAT(rowOf(subtractive, RunMode::Subtractive).noBakedShadow, HasSubstr("main light alone"));
}

// S10, S31. The overlap view needs the lights that lost their channels; other frames do not have them.
TEST(OverflowedLightsS10, AreAddedForTheOverlapViewAlone)
{
    BakedScene baked = stage();
    baked.scene.lights = {lamp(), lamp(LightMode::Baked, -1), lamp(LightMode::Baked, -1)};
    baked.scene.lights[2].mode = LightMode::Mixed;
    FramePlan frame = plan(baked, stageView(), RunMode::Shadowmask);
    EXPECT_EQ(frame.lights.size(), 1u);
    addOverflowedLights(baked, objectBounds(baked.scene), stageView(), frame);
    ASSERT_EQ(frame.lights.size(), 2u);
    EXPECT_EQ(frame.lights[1].light, 2);
    EXPECT_TRUE(frame.lights[1].overflowed);
    EXPECT_FALSE(frame.lights[1].hasBaked);
    const ivec3 cell = frame.clusters.clusterAt(vec2(0.5f), 12.0f);
    EXPECT_TRUE(frame.clusters.reaches(cell, 0));
    EXPECT_TRUE(frame.clusters.reaches(cell, 1));
    EXPECT_THAT(lightRows(baked, stageView(), frame)[2].notInFrame, HasSubstr("fully baked"));
}

TEST(RunTimeChangesS29, TheFrameSaysWhatChangesDoNotShow)
{
    BakedScene baked = stage();
    baked.scene.lights = {lamp(), lamp(LightMode::Baked, -1)};
    for (Light& light : baked.scene.lights) {
        light.baking.atBake = lightAtBake(light);
        light.baking.outerConeRadians = light.outerConeRadians;
    }
    EXPECT_THAT(plan(baked, stageView(), RunMode::Shadowmask).warnings, IsEmpty());
    baked.scene.lights[0].intensity *= 10.0f;
    baked.scene.lights[1].intensity = 0.0f; // a light that is off is not in the frame, and still said
    const FramePlan changed = plan(baked, stageView(), RunMode::Shadowmask);
    EXPECT_EQ(changed.warnings.size(), 2u);
    EXPECT_TRUE(anyWarning(changed, "bounced light stays"));
    EXPECT_TRUE(anyWarning(changed, "no effect: it is fully baked"));
    EXPECT_THAT(plan(baked, stageView(), RunMode::Realtime).warnings, IsEmpty()) << "nothing baked is shown";
}

// A light's own bias does what the same setting does for all lights.
TEST(ShadowBiasS2, OfALightStandsBeforeTheSettings)
{
    for (const LightType type : {LightType::Directional, LightType::Spot, LightType::Point}) {
        BakedScene baked = stage();
        baked.scene.lights = {lamp(LightMode::Mixed, 0, type)};
        ShadowSettings wide;
        wide.normalBiasTexels = 7.0f;
        const FramePlan bySetting = plan(baked, stageView(), RunMode::Shadowmask, wide);
        const FramePlan plain = plan(baked, stageView(), RunMode::Shadowmask);
        baked.scene.lights[0].shadowBias.normalTexels = 7.0f;
        const FramePlan byLight = plan(baked, stageView(), RunMode::Shadowmask);
        ASSERT_FALSE(byLight.tiles.empty());
        for (std::size_t i = 0; i < byLight.tiles.size(); ++i) {
            EXPECT_EQ(byLight.tiles[i].clipFromWorld, bySetting.tiles[i].clipFromWorld);
            EXPECT_NE(byLight.tiles[i].clipFromWorld, plain.tiles[i].clipFromWorld) << "no room for the shift";
        }
    }
    Light light;
    ShadowSettings settings;
    settings.depthBias = 0.3f;
    EXPECT_EQ(shadowSettingsOf(light, settings).depthBias, 0.3f);
    light.shadowBias = {0.0f, 2.5f, {}};
    EXPECT_EQ(shadowSettingsOf(light, settings).depthBias, 0.0f) << "0 is a bias, too";
    EXPECT_EQ(shadowSettingsOf(light, settings).slopeBias, 2.5f);
    EXPECT_EQ(shadowSettingsOf(light, settings).normalBiasTexels, settings.normalBiasTexels);
}

TEST(CascadeSplitsS2, AreSharesOfTheShadowDistance)
{
    BakedScene baked = stage();
    baked.scene.lights = {lamp(LightMode::Mixed, 0, LightType::Directional)};
    ShadowSettings settings;
    settings.distanceMeters = 50.0f;
    settings.cascadeSplits = {0.1f, 0.3f, 0.6f};
    ASSERT_TRUE(checkShadowSettings(settings));
    const auto far = plan(baked, stageView(), RunMode::Shadowmask, settings).cascadeFar;
    EXPECT_FLOAT_EQ(far[0], 5.0f);
    EXPECT_FLOAT_EQ(far[1], 15.0f);
    EXPECT_FLOAT_EQ(far[2], 30.0f);
    EXPECT_FLOAT_EQ(far[3], 50.0f);
    settings.cascades = 2;
    const auto two = plan(baked, stageView(), RunMode::Shadowmask, settings).cascadeFar;
    EXPECT_FLOAT_EQ(two[0], 5.0f);
    EXPECT_FLOAT_EQ(two[1], 50.0f);
    // A camera that sees less far than a split: no cascade ends beyond what it sees.
    settings.cascades = 4;
    FrameView near = stageView();
    near.camera.farMeters = 8.0f;
    const auto cut = plan(baked, near, RunMode::Shadowmask, settings).cascadeFar;
    EXPECT_FLOAT_EQ(cut[0], 5.0f);
    EXPECT_FLOAT_EQ(cut[2], cut[3]);
    EXPECT_LT(cut[3], 15.0f);
}

TEST(CascadeSplitsS2, Limits)
{
    const auto good = [](int cascades, std::array<float, 3> splits) {
        ShadowSettings settings;
        settings.cascades = cascades;
        settings.cascadeSplits = splits;
        return bool(checkShadowSettings(settings));
    };
    EXPECT_TRUE(good(4, {0, 0, 0})) << "by lambda";
    EXPECT_TRUE(good(4, {0.1f, 0.2f, 0.99f}));
    EXPECT_TRUE(good(2, {0.1f, 0, 0})) << "the rest is not read";
    EXPECT_FALSE(good(3, {0.1f, 0, 0}));
    EXPECT_FALSE(good(4, {0.3f, 0.2f, 0.5f}));
    EXPECT_FALSE(good(4, {0.1f, 0.1f, 0.5f}));
    EXPECT_FALSE(good(4, {0.1f, 0.2f, 1.0f}));
    EXPECT_FALSE(good(4, {-0.1f, 0.2f, 0.5f}));
    EXPECT_FALSE(good(4, {NAN, 0.2f, 0.5f}));
}

} // namespace
} // namespace halflight::light_rows_test
