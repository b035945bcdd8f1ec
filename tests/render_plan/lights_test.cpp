#include "plan_scene.h"

#include <cmath>
#include <gtest/gtest.h>
#include <string>
#include <utility>

namespace halflight::lights_test {
namespace {

using namespace test;

// Spec section 2 and S5…S12, row by row: what each kind of light is in each mode.
TEST(LightContractS5, EveryModeAndBakeType)
{
    struct Expected {
        bool present, hasBaked, skipStatic, staticCasters;
    };
    constexpr Expected kAbsent{false, false, false, false};
    constexpr Expected kPlain{true, false, false, true};       // lit and shadowed at run time by all casters
    constexpr Expected kMasked{true, true, false, false};      // min(F, B), dynamic casters only
    constexpr Expected kDistance{true, true, false, true};     // lerp(R, B, t), all casters
    constexpr Expected kSubtractMain{true, true, true, false}; // in the lightmap for static, min(F, B) for dynamic
    constexpr Expected kSubtractOther{true, false, true, false};
    const struct {
        const char* what;
        MixedLightingMode bake;
        RunMode mode;
        Expected realtime, masked, noChannel, baked;
    } table[] = {
        {"realtime", MixedLightingMode::Shadowmask, RunMode::Realtime, kPlain, kPlain, kPlain, kPlain},
        {"baked indirect", MixedLightingMode::BakedIndirect, RunMode::BakedIndirect, kPlain, kPlain, kPlain, kAbsent},
        {"baked indirect of a shadowmask bake", MixedLightingMode::Shadowmask, RunMode::BakedIndirect, kPlain, kPlain,
         kPlain, kAbsent},
        {"shadowmask", MixedLightingMode::Shadowmask, RunMode::Shadowmask, kPlain, kMasked, kPlain, kAbsent},
        {"distance", MixedLightingMode::Shadowmask, RunMode::DistanceShadowmask, kPlain, kDistance, kPlain, kAbsent},
        {"subtractive", MixedLightingMode::Subtractive, RunMode::Subtractive, kPlain, kSubtractMain, kSubtractOther,
         kAbsent},
    };
    for (const auto& row : table) {
        BakedScene baked = stage(row.bake);
        baked.scene.lights = {
            bakedLight("realtime", LightType::Directional, {}, {1, -2, 0}, LightMode::Realtime, -1),
            bakedLight("masked", LightType::Directional, {}, {0, -2, 1}, LightMode::Mixed, 0),
            bakedLight("noChannel", LightType::Spot, {0, 6, 0}, {0, -1, 0}, LightMode::Mixed, -1),
            bakedLight("baked", LightType::Directional, {}, {0, -2, -1}, LightMode::Baked, -1),
        };
        const FramePlan frame = plan(baked, stageView(), row.mode);
        const std::pair<const char*, Expected> lights[] = {
            {"realtime", row.realtime}, {"masked", row.masked}, {"noChannel", row.noChannel}, {"baked", row.baked}};
        for (const auto& [name, expected] : lights) {
            SCOPED_TRACE(std::string(row.what) + ", light " + name);
            const FrameLight* light = find(baked, frame, name);
            ASSERT_EQ(light != nullptr, expected.present);
            if (light == nullptr) continue;
            EXPECT_EQ(light->hasBaked, expected.hasBaked);
            EXPECT_EQ(light->channel, expected.hasBaked ? 0 : -1);
            EXPECT_EQ(light->skipStatic, expected.skipStatic);
            EXPECT_FALSE(light->skipDynamic);
            EXPECT_EQ(light->staticCasters, expected.staticCasters);
            // The dynamic box is in all volumes, so all of them have a shadow map; the floor is drawn only when said
            // so.
            ASSERT_TRUE(light->hasRealtimeShadow);
            bool floorDrawn = false;
            bool boxDrawn = false;
            for (int tile = light->firstTile; tile < light->firstTile + light->tileCount; ++tile) {
                for (const uint32_t object : frame.castersOf(tile)) (object == 0 ? floorDrawn : boxDrawn) = true;
            }
            EXPECT_TRUE(boxDrawn);
            EXPECT_EQ(floorDrawn, expected.staticCasters);
        }
        EXPECT_EQ(frame.usesMask, row.mode == RunMode::Shadowmask || row.mode == RunMode::DistanceShadowmask);
        EXPECT_EQ(frame.mainLight >= 0, row.mode == RunMode::Subtractive);
    }
}

TEST(LightContractS10, OverflowedMixedLightIsBaked)
{
    BakedScene baked = stage();
    Light fifth = bakedLight("fifth", LightType::Spot, {0, 5, 0}, {0, -1, 0}, LightMode::Baked, -1);
    fifth.mode = LightMode::Mixed; // as authored
    fifth.baking.reason = "four other mixed lights overlap it";
    baked.scene.lights = {fifth};
    EXPECT_EQ(find(baked, plan(baked, stageView(), RunMode::Shadowmask), "fifth"), nullptr);
    EXPECT_NE(find(baked, plan(baked, stageView(), RunMode::Realtime), "fifth"), nullptr);
}

TEST(MaskDetectionS11, OnlyWhenALightInViewUsesIt)
{
    BakedScene baked = stage();
    Light masked = bakedLight("masked", LightType::Point, {0, 2, 0}, {0, -1, 0}, LightMode::Mixed, 2);
    masked.rangeMeters = 4.0f;
    baked.scene.lights = {masked,
                          bakedLight("lamp", LightType::Directional, {}, {0, -1, 0.1f}, LightMode::Realtime, -1)};
    EXPECT_TRUE(plan(baked, stageView(), RunMode::Shadowmask).usesMask);
    EXPECT_FALSE(plan(baked, lookFrom({0, 4, 12}, {0, 0, 1}), RunMode::Shadowmask).usesMask) << "looking away";
    const FramePlan frame = plan(baked, stageView(), RunMode::Shadowmask);
    EXPECT_FALSE(find(baked, frame, "lamp")->hasBaked);
    EXPECT_EQ(find(baked, frame, "masked")->channel, 2);
}

TEST(LightSelectionS9, ChannelsStayWhateverTheOrder)
{
    BakedScene baked = stage();
    Random random(7);
    for (int i = 0; i < 40; ++i) {
        Light light = bakedLight("light " + std::to_string(i), LightType(i % 3), random.in({-8, 1, -8}, {8, 6, 8}),
                                 vec3(0.2f, -1, 0.1f) + 0.3f * random.direction(), LightMode::Mixed, i % 4);
        // Equal importances occur: position and name decide then.
        light.intensity = i % 5 == 0 ? 50.0f : random.in(1, 500);
        baked.scene.lights.push_back(light);
    }
    const FramePlan first = plan(baked, stageView(), RunMode::Shadowmask);
    ASSERT_EQ(first.lights.size(), 40u);
    for (int shuffle = 0; shuffle < 20; ++shuffle) {
        BakedScene shuffled = baked;
        for (std::size_t i = shuffled.scene.lights.size() - 1; i > 0; --i) {
            std::swap(shuffled.scene.lights[i], shuffled.scene.lights[random.generator()() % (i + 1)]);
        }
        const FramePlan frame = plan(shuffled, stageView(), RunMode::Shadowmask);
        ASSERT_EQ(frame.lights.size(), first.lights.size());
        for (std::size_t i = 0; i < frame.lights.size(); ++i) {
            const Light& a = baked.scene.lights[std::size_t(first.lights[i].light)];
            const Light& b = shuffled.scene.lights[std::size_t(frame.lights[i].light)];
            ASSERT_EQ(a.name, b.name) << "place " << i;
            EXPECT_EQ(frame.lights[i].channel, b.baking.occlusionMaskChannel);
            EXPECT_EQ(frame.lights[i].hasRealtimeShadow, first.lights[i].hasRealtimeShadow);
            EXPECT_EQ(frame.lights[i].firstTile, first.lights[i].firstTile);
        }
        EXPECT_EQ(frame.clusters.words, first.clusters.words);
        EXPECT_EQ(frame.tileCasters, first.tileCasters);
    }
}

TEST(LightSelection, DirectionalFirstThenByImportance)
{
    BakedScene baked = stage();
    baked.scene.lights = {
        bakedLight("near lamp", LightType::Point, {0, 4, 10}, {0, -1, 0}, LightMode::Realtime, -1),
        bakedLight("far lamp", LightType::Point, {0, 4, -10}, {0, -1, 0}, LightMode::Realtime, -1),
        bakedLight("moon", LightType::Directional, {}, {0, -1, 0}, LightMode::Realtime, -1),
        bakedLight("off", LightType::Point, {0, 4, 9}, {0, -1, 0}, LightMode::Realtime, -1),
    };
    baked.scene.lights[2].intensity = 0.01f;
    baked.scene.lights[3].intensity = 0.0f;
    const FramePlan frame = plan(baked, stageView(), RunMode::Realtime);
    ASSERT_EQ(frame.lights.size(), 3u) << "a light that is off is no light";
    EXPECT_EQ(frame.lights[0].light, 2);
    EXPECT_EQ(frame.lights[1].light, 0);
    EXPECT_EQ(frame.lights[2].light, 1);
}

TEST(LightSelection, CullsWhatCannotReachTheView)
{
    BakedScene baked = stage();
    const auto add = [&](const char* name, LightType type, vec3 p, vec3 d, float range) {
        Light light = bakedLight(name, type, p, d, LightMode::Realtime, -1);
        light.rangeMeters = range;
        light.outerConeRadians = 0.4f;
        baked.scene.lights.push_back(light);
    };
    add("point in view", LightType::Point, {0, 1, 0}, {0, -1, 0}, 3);
    add("point reaching into view", LightType::Point, {0, 4, 14}, {0, -1, 0}, 4);
    add("point behind", LightType::Point, {0, 4, 20}, {0, -1, 0}, 4);
    add("unlimited point behind", LightType::Point, {0, 4, 20}, {0, -1, 0}, 0);
    add("spot behind looking away", LightType::Spot, {0, 4, 14}, {0, 0, 1}, 10);
    add("spot behind looking in", LightType::Spot, {0, 4, 14}, {0, 0, -1}, 10);
    add("unlimited spot looking away", LightType::Spot, {0, 4, 14}, {0, 0, 1}, 0);
    const FramePlan frame = plan(baked, stageView(), RunMode::Realtime);
    EXPECT_NE(find(baked, frame, "point in view"), nullptr);
    EXPECT_NE(find(baked, frame, "point reaching into view"), nullptr);
    EXPECT_EQ(find(baked, frame, "point behind"), nullptr);
    EXPECT_NE(find(baked, frame, "unlimited point behind"), nullptr);
    EXPECT_EQ(find(baked, frame, "spot behind looking away"), nullptr);
    EXPECT_NE(find(baked, frame, "spot behind looking in"), nullptr);
    EXPECT_EQ(find(baked, frame, "unlimited spot looking away"), nullptr);
}

// Brute force: a light that lights any point in view is in the frame.
TEST(LightSelection, NeverCullsALightThatReachesTheView)
{
    Random random(11);
    int culled = 0;
    for (int n = 0; n < 400; ++n) {
        BakedScene baked = emptyScene();
        Light light = bakedLight("l", n % 2 ? LightType::Spot : LightType::Point, random.in(vec3(-30), vec3(30)),
                                 random.direction(), LightMode::Realtime, -1);
        light.rangeMeters = random.in(0.5f, 15.0f);
        light.outerConeRadians = random.in(0.05f, kPi / 2);
        baked.scene.lights = {light};
        FrameView view = lookFrom(random.in(vec3(-5), vec3(5)), random.direction());
        view.camera.orthographic = n % 5 == 0;
        view.camera.orthographicHeightMeters = 8.0f;
        view.camera.farMeters = 40.0f;
        if (plan(baked, view, RunMode::Realtime).lights.size() == 1) continue;
        ++culled;
        for (int i = 0; i < 2000; ++i) {
            const vec3 p = pointInView(view, {random.unit(), random.unit()}, random.in(view.camera.nearMeters, 40.0f));
            const vec3 d = p - light.position();
            const bool inCone = light.type == LightType::Point ||
                                glm::dot(d, light.direction()) >= glm::length(d) * std::cos(light.outerConeRadians);
            ASSERT_FALSE(glm::length(d) < light.rangeMeters && inCone) << "light " << n;
        }
    }
    EXPECT_GT(culled, 100) << "most of these lights are nowhere near the view";
}

TEST(LightSelection, MoreThan256AreNamed)
{
    BakedScene baked = stage();
    for (int i = 0; i < 300; ++i) {
        baked.scene.lights.push_back(bakedLight("lamp " + std::to_string(i), LightType::Point,
                                                {0, 2, -0.01f * float(i)}, {0, -1, 0}, LightMode::Realtime, -1));
        baked.scene.lights.back().intensity = float(1000 - i);
        baked.scene.lights.back().castShadows = false;
    }
    const FramePlan frame = plan(baked, stageView(), RunMode::Realtime);
    ASSERT_EQ(frame.lights.size(), std::size_t(kMaxFrameLights));
    int left = 0;
    for (int i = 0; i < 300; ++i) {
        const std::string name = "\"lamp " + std::to_string(i) + "\"";
        const bool present = find(baked, frame, "lamp " + std::to_string(i)) != nullptr;
        EXPECT_EQ(anyWarning(frame, name), !present) << name;
        left += present ? 0 : 1;
    }
    EXPECT_EQ(left, 44);
    EXPECT_NE(find(baked, frame, "lamp 0"), nullptr);
    EXPECT_EQ(find(baked, frame, "lamp 299"), nullptr) << "dimmest";
}

TEST(RunTimeChangesS29, MovedLightsAreReported)
{
    const auto warned = [](LightType type, LightMode bakeType, RunMode mode, auto change) {
        BakedScene baked =
            stage(mode == RunMode::Subtractive ? MixedLightingMode::Subtractive : MixedLightingMode::Shadowmask);
        baked.scene.lights = {bakedLight("lamp", type, {1, 3, 2}, {0.1f, -1, 0}, bakeType, 0)};
        change(baked.scene.lights[0]);
        return anyWarning(plan(baked, stageView(), mode), "light \"lamp\" was moved after the bake; its baked ");
    };
    const auto nothing = [](Light&) {};
    const auto move = [](Light& light) { light.worldFromLight[3].x += 0.01f; };
    const auto hair = [](Light& light) { light.worldFromLight[3].x += 0.0005f; };
    const auto turn = [](Light& light) { light.worldFromLight = pose(light.position(), {0.15f, -1, 0}); };
    const auto roll = [](Light& light) {
        light.worldFromLight[0] = -light.worldFromLight[0];
        light.worldFromLight[1] = -light.worldFromLight[1];
    };
    const auto recolor = [](Light& light) { light.color = {1, 0.2f, 0}, light.intensity *= 3; };
    using enum LightType;
    for (const LightType type : {Directional, Point, Spot}) {
        SCOPED_TRACE(int(type));
        EXPECT_FALSE(warned(type, LightMode::Mixed, RunMode::Shadowmask, nothing));
        EXPECT_FALSE(warned(type, LightMode::Mixed, RunMode::Shadowmask, hair));
        EXPECT_FALSE(warned(type, LightMode::Mixed, RunMode::Shadowmask, recolor)) << "may change at run time";
        EXPECT_FALSE(warned(type, LightMode::Mixed, RunMode::Shadowmask, roll))
            << "turning about its axis changes nothing";
        EXPECT_EQ(warned(type, LightMode::Mixed, RunMode::Shadowmask, move), type != Directional);
        EXPECT_EQ(warned(type, LightMode::Mixed, RunMode::Subtractive, turn), type != Point);
        EXPECT_EQ(warned(type, LightMode::Baked, RunMode::Shadowmask, turn), type != Point);
        EXPECT_FALSE(warned(type, LightMode::Mixed, RunMode::Realtime, turn)) << "nothing baked is shown";
        EXPECT_FALSE(warned(type, LightMode::Realtime, RunMode::Shadowmask, turn));
    }
}

TEST(RunTimeChangesS29, WarningSaysWhatIsOutOfStep)
{
    BakedScene baked = stage();
    baked.scene.lights = {bakedLight("lamp", LightType::Spot, {1, 3, 2}, {0, -1, 0}, LightMode::Mixed, 0)};
    baked.scene.lights[0].worldFromLight[3].x += 1.0f;
    EXPECT_TRUE(anyWarning(plan(baked, stageView(), RunMode::Shadowmask),
                           "light \"lamp\" was moved after the bake; its baked shadows are out of step"));
    EXPECT_TRUE(anyWarning(plan(baked, stageView(), RunMode::BakedIndirect), "its baked light is out of step"));
}

TEST(OnlyBakedS19, NoCasterMeansNoShadowMap)
{
    BakedScene baked = stage();
    Light lamp = bakedLight("lamp", LightType::Spot, {0, 6, 0}, {0, -1, 0}, LightMode::Mixed, 1);
    lamp.rangeMeters = 10;
    baked.scene.lights = {lamp, bakedLight("sun", LightType::Directional, {}, {0.1f, -1, 0}, LightMode::Mixed, 0)};
    for (const char* name : {"lamp", "sun"}) {
        EXPECT_TRUE(find(baked, plan(baked, stageView(), RunMode::Shadowmask), name)->hasRealtimeShadow) << name;
    }
    const auto expectNone = [&](const BakedScene& changed, RunMode mode, const char* name, const char* why) {
        const FramePlan frame = plan(changed, stageView(), mode);
        const FrameLight* light = find(changed, frame, name);
        ASSERT_NE(light, nullptr);
        EXPECT_FALSE(light->hasRealtimeShadow) << why;
        EXPECT_EQ(light->firstTile, -1);
        EXPECT_EQ(light->tileCount, 0);
        const Light& source = changed.scene.lights[std::size_t(light->light)];
        const bool throwsShadows = source.castShadows && source.shadowStrength > 0.0f;
        EXPECT_EQ(light->hasBaked, throwsShadows) << "baked shadows stay, but for lights whose shadows are off";
    };
    BakedScene away = baked;
    away.scene.objects[1].worldFromObject[3] = vec4(9, 1, 0, 1);
    expectNone(away, RunMode::Shadowmask, "lamp", "the dynamic box is outside the cone");
    BakedScene noCast = baked;
    noCast.scene.objects[1].castShadows = false; // S30
    expectNone(noCast, RunMode::Shadowmask, "lamp", "the dynamic box casts no shadows");
    expectNone(noCast, RunMode::Shadowmask, "sun", "the dynamic box casts no shadows");
    EXPECT_TRUE(find(noCast, plan(noCast, stageView(), RunMode::DistanceShadowmask), "sun")->hasRealtimeShadow)
        << "the floor casts";
    BakedScene weak = baked;
    for (Light& light : weak.scene.lights) light.shadowStrength = 0.0f;
    expectNone(weak, RunMode::Shadowmask, "sun", "strength 0 shows no shadow");
    BakedScene off = baked;
    for (Light& light : off.scene.lights) light.castShadows = false;
    expectNone(off, RunMode::DistanceShadowmask, "lamp", "the light casts no shadows");

    ShadowSettings shortSight;
    shortSight.distanceMeters = 3.0f;
    BakedScene distant = baked;
    distant.scene.lights[0].rangeMeters = 7.0f;
    EXPECT_FALSE(find(distant, plan(distant, stageView(), RunMode::Shadowmask, shortSight), "lamp")->hasRealtimeShadow)
        << "all it lights is beyond the shadow distance";
}

TEST(PointLightsS4, ShadowsCanBeSwitchedOff)
{
    BakedScene baked = stage();
    baked.scene.lights = {bakedLight("bulb", LightType::Point, {0, 4, 0}, {0, -1, 0}, LightMode::Mixed, 3)};
    const FramePlan on = plan(baked, stageView(), RunMode::DistanceShadowmask);
    EXPECT_TRUE(find(baked, on, "bulb")->hasRealtimeShadow);
    EXPECT_EQ(find(baked, on, "bulb")->tileCount, 6);
    ShadowSettings settings;
    settings.pointShadows = false;
    const FramePlan off = plan(baked, stageView(), RunMode::DistanceShadowmask, settings);
    EXPECT_FALSE(find(baked, off, "bulb")->hasRealtimeShadow);
    EXPECT_TRUE(find(baked, off, "bulb")->hasBaked) << "A = B at every distance";
}

} // namespace
} // namespace halflight::lights_test
