// A rendered pixel equals the law's value: a floor in four columns (lit; in static shadow; in dynamic shadow; in both),
// seen near, at nine places within the fade, and beyond the shadow distance, in every mode, forward and deferred (S26).
#include "render/law/law_modes.h"

#include <glm/gtc/packing.hpp>

namespace halflight::test::law_pixels_test {
namespace {

using namespace law;

class LawPixels : public RenderTest, public testing::WithParamInterface<ModeStrengthPath> {};
INSTANTIATE_TEST_SUITE_P(S1S7S12S13S20toS25, LawPixels,
                         testing::Combine(kAllModes, testing::Values(1.0f, 0.6f), kBothPaths), modeStrengthPathName);

TEST_P(LawPixels, StaticReceiver)
{
    const auto [mode, strength, path] = GetParam();
    LawScene law = makeScene(bakeModeFor(mode));
    Scene& scene = law.baked.scene;
    scene.lights[0].shadowStrength = strength;
    scene.subtractiveShadowColor = kShadowColor;
    const RenderedFrame frame = render(law.baked, makeCamera(), settingsFor(mode, path));
    expectSites(frame, [&, mode = mode, strength = strength](const Site& site) {
        const vec3 lightmap = lightmapOf(site.column);
        const float realtime = realtimeOf(mode, site.column);
        if (mode == RunMode::Subtractive)
            return indirectRadiance(site.point, subtractiveByHand(lightmap, vec3(kSunLux * kToSun.y), realtime,
                                                                  site.fade, kShadowColor, strength));
        const float attenuation =
            attenuationByHand(mode, usesMask(mode), maskOf(site.column), true, realtime, site.fade, strength);
        const vec3 direct = directRadiance(site.point, scene.lights[0], attenuation);
        return mode == RunMode::Realtime ? direct : direct + indirectRadiance(site.point, lightmap);
    });
}

/// Subtractive with the main light's own mask, at both strengths.
class SubtractiveMaskS22 : public RenderTest, public testing::WithParamInterface<ModeStrengthPath> {};
INSTANTIATE_TEST_SUITE_P(, SubtractiveMaskS22,
                         testing::Combine(testing::Values(RunMode::Subtractive), testing::Values(1.0f, 0.6f),
                                          kBothPaths),
                         modeStrengthPathName);

TEST_P(SubtractiveMaskS22, OnlyLightThatArrivesIsTakenAway)
{
    const auto [mode, strength, path] = GetParam();
    LawScene law = makeScene(MixedLightingMode::Subtractive);
    addMainLightMask(law);
    law.baked.scene.lights[0].shadowStrength = strength;
    law.baked.scene.subtractiveShadowColor = vec3(0.0f);
    const RenderedFrame frame = render(law.baked, makeCamera(), settingsFor(mode, path));
    EXPECT_TRUE(frame.plan.subtractsByMask);
    EXPECT_TRUE(frame.forwardReadsMask);
    expectSites(frame, [&, strength = strength](const Site& site) {
        return indirectRadiance(site.point, subtractiveByHand(lightmapOf(site.column), vec3(kSunLux * kToSun.y),
                                                              realtimeOf(RunMode::Subtractive, site.column), site.fade,
                                                              vec3(0.0f), strength, maskOf(site.column)));
    });
}

// A mask is of use to the light that holds its channel alone: where the main light has none, B is 1.
TEST_P(SubtractiveMaskS22, MaskOfNobodyCountsForNothing)
{
    const auto [mode, strength, path] = GetParam();
    LawScene law = makeScene(MixedLightingMode::Subtractive);
    addMainLightMask(law);
    law.baked.scene.lights[0].shadowStrength = strength;
    law.baked.scene.lights[0].baking.occlusionMaskChannel = -1;
    const RenderedFrame frame = render(law.baked, makeCamera(), settingsFor(mode, path));
    EXPECT_FALSE(frame.forwardReadsMask);
    expectSites(frame, [&, strength = strength](const Site& site) {
        return indirectRadiance(site.point, subtractiveByHand(lightmapOf(site.column), vec3(kSunLux * kToSun.y),
                                                              realtimeOf(RunMode::Subtractive, site.column), site.fade,
                                                              vec3(0.0f), strength));
    });
}

// S23. The setting comes before the author's colour, which comes before the bake's.
TEST_P(SubtractiveMaskS22, ShadowColorOfSettingsAuthorAndBake)
{
    const auto [mode, strength, path] = GetParam();
    LawScene law = makeScene(MixedLightingMode::Subtractive);
    law.baked.scene.lights[0].shadowStrength = strength;
    RenderSettings settings = settingsFor(mode, path);
    const auto expectColor = [&, strength = strength](vec3 color) {
        expectSites(render(law.baked, makeCamera(), settings), [&](const Site& site) {
            return indirectRadiance(site.point, subtractiveByHand(lightmapOf(site.column), vec3(kSunLux * kToSun.y),
                                                                  realtimeOf(RunMode::Subtractive, site.column),
                                                                  site.fade, color, strength));
        });
    };
    law.baked.defaultShadowColor = vec3(0.125f, 0.25f, 0.5f);
    expectColor(law.baked.defaultShadowColor);
    law.baked.scene.subtractiveShadowColor = kShadowColor;
    expectColor(kShadowColor);
    settings.subtractiveShadowColor = vec3(0.0f);
    expectColor(vec3(0.0f));
    settings.subtractiveShadowColor = vec3(-1.0f, 0.0f, 0.0f);
    ASSERT_TRUE(renderer->load(law.baked));
    EXPECT_FALSE(renderer->render(makeCamera(), settings));
}

class LightmapUnitS6 : public BothPaths {};

// A file whose texels are in another unit shows the same picture, bit for bit where the unit is a power of two.
TEST_P(LightmapUnitS6, ScalesTheLightmapAndNothingElse)
{
    for (const RunMode mode : {RunMode::BakedIndirect, RunMode::Subtractive}) {
        LawScene law = makeScene(bakeModeFor(mode));
        const RenderedFrame lux = render(law.baked, makeCamera(), settingsFor(mode, GetParam()));
        for (uint32_t& texel : law.baked.lightmaps[0].texels())
            texel = glm::packF3x9_E1x5(glm::unpackF3x9_E1x5(texel) / 16.0f);
        law.baked.lightmapUnitLux = 16.0f;
        const RenderedFrame scaled = render(law.baked, makeCamera(), settingsFor(mode, GetParam()));
        EXPECT_EQ(lux.radiance.texels(), scaled.radiance.texels());
    }
}
INSTANTIATE_TEST_SUITE_P(Paths, LightmapUnitS6, kBothPaths, pathNameOf);

TEST_P(LawPixels, DynamicReceiverReadsItsProbe)
{
    const auto [mode, strength, path] = GetParam();
    LawScene law = makeScene(bakeModeFor(mode));
    law.baked.scene.lights[0].shadowStrength = strength;
    makeFloorDynamic(law);
    const RenderedFrame frame = render(law.baked, makeCamera(), settingsFor(mode, path));
    expectSites(frame, [&, mode = mode, strength = strength](const Site& site) {
        const bool occluded = usesMask(mode) || mode == RunMode::Subtractive;
        const float attenuation = attenuationByHand(mode, occluded, kProbeOcclusion, true,
                                                    realtimeOf(mode, site.column), site.fade, strength);
        const vec3 direct = directRadiance(site.point, law.baked.scene.lights[0], attenuation);
        return mode == RunMode::Realtime ? direct : direct + indirectRadiance(site.point, kProbeRadiance * kPi);
    });
}

// No caster in view: no light has a shadow map, and mask and occlusion hold at every distance. Subtractive takes
// nothing from its lightmaps and has channel 0 of the probes on dynamic receivers (S25).
class OnlyBakedShadowsS19 : public RenderTest, public testing::WithParamInterface<ModeStrengthPath> {
protected:
    RenderedFrame drawWithoutCasters(LawScene& law)
    {
        const auto [mode, strength, path] = GetParam();
        for (Object& object : law.baked.scene.objects) object.castShadows = false;
        law.baked.scene.lights[0].shadowStrength = strength;
        RenderedFrame frame = render(law.baked, makeCamera(), settingsFor(mode, path));
        for (const FrameLight& light : frame.plan.lights) EXPECT_FALSE(light.hasRealtimeShadow);
        return frame;
    }
};
INSTANTIATE_TEST_SUITE_P(S25, OnlyBakedShadowsS19,
                         testing::Combine(kBakedModes, testing::Values(1.0f, 0.6f), kBothPaths), modeStrengthPathName);

TEST_P(OnlyBakedShadowsS19, StaticReceiverKeepsItsMask)
{
    const RunMode mode = std::get<0>(GetParam());
    const float strength = std::get<1>(GetParam());
    LawScene law = makeScene(bakeModeFor(mode));
    expectSites(drawWithoutCasters(law), [&](const Site& site) {
        const vec3 indirect = indirectRadiance(site.point, lightmapOf(site.column));
        if (mode == RunMode::Subtractive) return indirect;
        const float attenuation = usesMask(mode) ? 1.0f - strength + strength * maskOf(site.column) : 1.0f;
        return indirect + directRadiance(site.point, law.baked.scene.lights[0], attenuation);
    });
}

TEST_P(OnlyBakedShadowsS19, DynamicReceiverKeepsItsOcclusion)
{
    const RunMode mode = std::get<0>(GetParam());
    const float strength = std::get<1>(GetParam());
    LawScene law = makeScene(bakeModeFor(mode));
    makeFloorDynamic(law);
    expectSites(drawWithoutCasters(law), [&](const Site& site) {
        const float attenuation = mode == RunMode::BakedIndirect ? 1.0f : 1.0f - strength + strength * kProbeOcclusion;
        return indirectRadiance(site.point, kProbeRadiance * kPi) +
               directRadiance(site.point, law.baked.scene.lights[0], attenuation);
    });
}

class OtherLights : public RenderTest, public testing::WithParamInterface<ModePath> {};
INSTANTIATE_TEST_SUITE_P(, OtherLights, testing::Combine(kBakedModes, kBothPaths), modePathName);

// S11. A realtime sun beside the masked one: every caster in its shadow map, none of the other's mask, lit beyond the
// shadow distance; the masked one does not notice it.
TEST_P(OtherLights, RealtimeSunIsUntouchedByMasksS11)
{
    const auto [mode, path] = GetParam();
    for (const bool isDynamic : {false, true}) {
        LawScene law = makeScene(bakeModeFor(mode));
        if (isDynamic) makeFloorDynamic(law);
        Scene& scene = law.baked.scene;
        scene.subtractiveShadowColor = kShadowColor;
        scene.lights.push_back(directionalLight(kToSun, 2.0f));
        const RenderedFrame frame = render(law.baked, makeCamera(), settingsFor(mode, path));
        expectSites(frame, [&, mode = mode](const Site& site) {
            const float all = inStaticShadow(site.column) || inDynamicShadow(site.column) ? 0.0f : 1.0f;
            const vec3 realtimeSun = directRadiance(
                site.point, scene.lights[1], attenuationByHand(RunMode::Realtime, false, 1, true, all, site.fade, 1));
            const float realtime = realtimeOf(mode, site.column);
            vec3 irradiance = isDynamic ? kProbeRadiance * kPi : lightmapOf(site.column);
            if (mode == RunMode::Subtractive && !isDynamic)
                return realtimeSun +
                       indirectRadiance(site.point, subtractiveByHand(irradiance, vec3(kSunLux * kToSun.y), realtime,
                                                                      site.fade, kShadowColor, 1.0f));
            const float baked = isDynamic ? kProbeOcclusion : maskOf(site.column);
            return realtimeSun + indirectRadiance(site.point, irradiance) +
                   directRadiance(
                       site.point, scene.lights[0],
                       attenuationByHand(mode, mode != RunMode::BakedIndirect, baked, true, realtime, site.fade, 1.0f));
        });
    }
}

// S5, S10. What the bake made fully baked (authored so, or a mixed light that found no channel) is drawn by no mode
// that reads the bake, and in realtime mode as any light.
TEST_P(OtherLights, FullyBakedLightIsNotDrawnAgainS5S10)
{
    const auto [mode, path] = GetParam();
    LawScene law = makeScene(bakeModeFor(mode));
    Light& sun = law.baked.scene.lights[0];
    sun.baking.bakeType = LightMode::Baked;
    sun.baking.occlusionMaskChannel = -1;
    const RenderedFrame frame = render(law.baked, makeCamera(), settingsFor(mode, path));
    EXPECT_TRUE(frame.plan.lights.empty());
    expectSites(frame, [&](const Site& site) { return indirectRadiance(site.point, lightmapOf(site.column)); });
    const RenderedFrame realtime = render(law.baked, makeCamera(), settingsFor(RunMode::Realtime, path));
    expectSites(realtime, [&](const Site& site) {
        return directRadiance(site.point, sun,
                              attenuationByHand(RunMode::Realtime, false, 1.0f, true,
                                                realtimeOf(RunMode::Realtime, site.column), site.fade, 1.0f));
    });
}

// S21. Subtractive's second mixed sun: wholly in the lightmap of static receivers, realtime on dynamic ones, whose
// occlusion it does not read; its shadow map holds dynamic objects only.
class SecondSunS25 : public BothPaths {};
INSTANTIATE_TEST_SUITE_P(, SecondSunS25, kBothPaths, pathNameOf);

TEST_P(SecondSunS25, BakedForStaticRealtimeForDynamicReceivers)
{
    for (const bool isDynamic : {false, true}) {
        LawScene law = makeScene(MixedLightingMode::Subtractive);
        if (isDynamic) makeFloorDynamic(law);
        Scene& scene = law.baked.scene;
        Light second = directionalLight(kToSun, 5.0f);
        bakeAsMixed(second, MixedLightingMode::Subtractive, -1);
        scene.lights.push_back(second);
        const RenderedFrame frame = render(law.baked, makeCamera(), settingsFor(RunMode::Subtractive, GetParam()));
        expectSites(frame, [&](const Site& site) {
            const float realtime = realtimeOf(RunMode::Subtractive, site.column);
            if (!isDynamic)
                return indirectRadiance(site.point, subtractiveByHand(lightmapOf(site.column), vec3(kSunLux * kToSun.y),
                                                                      realtime, site.fade, vec3(0.0f), 1.0f));
            return indirectRadiance(site.point, kProbeRadiance * kPi) +
                   directRadiance(site.point, scene.lights[0],
                                  attenuationByHand(RunMode::Subtractive, true, kProbeOcclusion, true, realtime,
                                                    site.fade, 1.0f)) +
                   directRadiance(
                       site.point, second,
                       attenuationByHand(RunMode::Subtractive, false, 1.0f, true, realtime, site.fade, 1.0f));
        });
    }
}

} // namespace
} // namespace halflight::test::law_pixels_test
