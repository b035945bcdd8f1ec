// Which lights share a shadowmask channel (spec S9, S10, S25).

#include "bake/lights/channels.h"
#include "bake/report/bake_report.h"
#include "bake/test_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace halflight::test::channel_assignment_test {
namespace {

constexpr int kPage = 64;

/// Whether two lights of the scene reach a common point, by sampling space.
bool reachCommonPoint(const Light& a, const Light& b, std::mt19937& random)
{
    std::uniform_real_distribution<float> u(-12.0f, 12.0f);
    const auto reaches = [](const Light& light, vec3 p) {
        if (light.type == LightType::Directional) return true;
        const vec3 offset = p - light.position();
        const float distance = glm::length(offset);
        if (light.rangeMeters > 0.0f && distance >= light.rangeMeters) return false;
        return light.type != LightType::Spot ||
               glm::dot(offset / distance, light.direction()) > std::cos(light.outerConeRadians);
    };
    for (int i = 0; i < 4000; ++i) {
        const vec3 p(u(random), u(random), u(random));
        if (reaches(a, p) && reaches(b, p)) return true;
    }
    return false;
}

TEST(ChannelsS9, LightsThatOverlapNeverShareAndOthersDo)
{
    std::mt19937 random(7);
    std::uniform_real_distribution<float> u(-10.0f, 10.0f);
    for (int trial = 0; trial < 30; ++trial) {
        Scene scene;
        for (int i = 0; i < 12; ++i) {
            Light light = pointAt("p" + std::to_string(i), vec3(u(random), u(random), u(random)),
                                  2.0f + 0.3f * float(i), float(i + 1));
            if (i % 3 == 0) {
                light.type = LightType::Spot;
                light.outerConeRadians = 0.2f + 0.1f * float(i);
                light.worldFromLight = lightPose(light.position(), vec3(u(random), u(random), u(random)));
            }
            scene.lights.push_back(light);
        }
        if (trial % 2)
            scene.lights.push_back(makeLight(LightType::Directional, vec3(0), vec3(0, -1, 0), 1.0f, LightMode::Mixed));
        assignShadowmaskChannels(scene, MixedLightingMode::Shadowmask);
        for (std::size_t i = 0; i < scene.lights.size(); ++i) {
            const BakingOutput& a = scene.lights[i].baking;
            EXPECT_EQ(a.occlusionMaskChannel >= 0, a.bakeType == LightMode::Mixed);
            EXPECT_LT(a.occlusionMaskChannel, 4);
            for (std::size_t j = i + 1; j < scene.lights.size(); ++j) {
                const BakingOutput& b = scene.lights[j].baking;
                if (a.occlusionMaskChannel < 0 || a.occlusionMaskChannel != b.occlusionMaskChannel) continue;
                EXPECT_FALSE(reachCommonPoint(scene.lights[i], scene.lights[j], random))
                    << scene.lights[i].name << " and " << scene.lights[j].name;
            }
        }
    }
    Scene apart;
    for (int i = 0; i < 20; ++i)
        apart.lights.push_back(pointAt("p" + std::to_string(i), vec3(float(i) * 10.0f, 0, 0), 4.9f));
    assignShadowmaskChannels(apart, MixedLightingMode::Shadowmask);
    for (const Light& light : apart.lights) EXPECT_EQ(light.baking.occlusionMaskChannel, 0);
}

TEST(ChannelsS9, OrderOfLightsDoesNotMatter)
{
    std::vector<Light> lights;
    for (int i = 0; i < 9; ++i)
        lights.push_back(pointAt("p" + std::to_string(i), vec3(float(i) * 2.0f, 0, 0), 3.5f, float(10 + i)));
    std::map<std::string, int> expected;
    std::mt19937 random(3);
    for (int trial = 0; trial < 20; ++trial) {
        Scene scene;
        scene.lights = lights;
        assignShadowmaskChannels(scene, MixedLightingMode::Shadowmask);
        for (const Light& light : scene.lights) {
            const auto [found, fresh] = expected.emplace(light.name, light.baking.occlusionMaskChannel);
            EXPECT_EQ(found->second, light.baking.occlusionMaskChannel) << light.name;
        }
        std::shuffle(lights.begin(), lights.end(), random);
    }
}

TEST(ChannelsS10, TheFifthOverlappingLightIsBakedAndNamed)
{
    Scene scene;
    for (int i = 0; i < 5; ++i)
        scene.lights.push_back(pointAt("lamp " + std::to_string(i), vec3(float(i), 0, 0), 20.0f, float(50 - i)));
    assignShadowmaskChannels(scene, MixedLightingMode::Shadowmask);
    std::set<int> channels;
    for (int i = 0; i < 4; ++i) {
        EXPECT_EQ(scene.lights[std::size_t(i)].baking.bakeType, LightMode::Mixed);
        channels.insert(scene.lights[std::size_t(i)].baking.occlusionMaskChannel);
    }
    EXPECT_EQ(channels, (std::set<int>{0, 1, 2, 3}));
    const BakingOutput& fifth = scene.lights[4].baking;
    EXPECT_EQ(fifth.bakeType, LightMode::Baked);
    EXPECT_EQ(fifth.occlusionMaskChannel, -1);
    EXPECT_NE(fifth.reason.find("lamp 0"), std::string::npos) << fifth.reason;
}

/// Directional lights reach everything: no cure speaks of a range where four of them hold the channels.
TEST(ChannelsS10, NoRangeIsACureForDirectionalLights)
{
    const auto reasons = [](int suns, const std::vector<Light>& others) {
        Scene scene;
        for (int i = 0; i < suns; ++i) {
            Light& sun = scene.lights.emplace_back();
            sun.type = LightType::Directional;
            sun.name = "sun " + std::to_string(i);
            sun.intensity = float(10 - i);
        }
        scene.lights.insert(scene.lights.end(), others.begin(), others.end());
        assignShadowmaskChannels(scene, MixedLightingMode::Shadowmask);
        BakeReport report;
        reportLights(scene, report);
        std::string all;
        for (const Light& light : scene.lights) all += light.baking.reason;
        for (const std::string& warning : report.warnings) all += warning;
        return all;
    };
    const Light limited = pointAt("lamp", vec3(0), 5.0f, 50.0f);
    Light limitless = limited;
    limitless.rangeMeters = 0.0f;
    for (const std::string& reason : {reasons(5, {}), reasons(4, {limited}), reasons(4, {limitless}), reasons(8, {}),
                                      reasons(5, {limited, limitless})}) {
        EXPECT_NE(reason.find("sun 0"), std::string::npos) << reason;
        EXPECT_NE(reason.find("realtime or baked"), std::string::npos) << reason;
        EXPECT_EQ(reason.find("range"), std::string::npos) << reason;
    }
    // A lamp among lamps and suns: the lamps' ranges are the cure, and the suns are not among those to be shortened.
    const Light other = pointAt("other lamp", vec3(1, 0, 0), 5.0f, 90.0f);
    const std::string mixed = reasons(3, {other, limited});
    EXPECT_NE(mixed.find("shorter ranges, until it overlaps one less of \"other lamp\""), std::string::npos) << mixed;
}

/// Up to three fully baked lights get a warning each with its cure; more share one. The report has the reason of each.
TEST(ChannelsS10, ManyOverflowingLightsShareOneWarning)
{
    for (const int count : {7, 8, 17}) {
        Scene scene;
        for (int i = 0; i < count; ++i)
            scene.lights.push_back(pointAt("lamp " + std::to_string(i), vec3(float(i), 0, 0), 60.0f, float(50 - i)));
        assignShadowmaskChannels(scene, MixedLightingMode::Shadowmask);
        BakeReport report;
        reportLights(scene, report);
        EXPECT_EQ(report.warnings.size(), count == 7 ? 3u : 1u);
        EXPECT_NE(report.warnings[0].find("\"lamp 4\""), std::string::npos) << report.warnings[0];
        EXPECT_NE(report.warnings[0].find("fully baked"), std::string::npos) << report.warnings[0];
        EXPECT_EQ(std::ranges::count_if(report.lights, [](const LightReport& l) { return !l.reason.empty(); }),
                  count - 4);
    }
}

/// The overflowing light's direct light is in the lightmap: nothing is dropped.
TEST(ChannelsS10, OverflowIsRightInTheLightmap)
{
    Scene scene;
    addRectangle(scene, {vec3(-1, 0, 1), vec3(2, 0, 0), vec3(0, 0, -2)}, addMaterial(scene, vec3(0)), kPage,
                 {vec2(1), vec2(63)});
    for (int i = 0; i < 5; ++i)
        scene.lights.push_back(
            pointAt("lamp " + std::to_string(i), vec3(0.3f * float(i), 1.5f, 0), 20.0f, float(50 - i)));
    Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, {});
    const auto estimates = bench.irradiance();
    for (std::size_t i = 0; i < estimates.size(); i += 17) {
        const vec3 toLight = bench.scene.lights[4].position() - bench.positionOf(bench.map.texels[i]);
        const float d = glm::length(toLight);
        const float window = 1.0f - std::pow(d / 20.0f, 4.0f);
        const float expected = 46.0f * window / (d * d) * toLight.y / d;
        EXPECT_NEAR(estimates[i].irradiance.x, expected, 3e-3f * expected);
    }
}

/// A street of a thousand lamps, each overlapping a handful: nearly all keep a channel, and nobody waits.
TEST(ChannelsS9, AThousandLights)
{
    Scene scene;
    for (int i = 0; i < 1000; ++i) {
        scene.lights.push_back(
            pointAt("lamp " + std::to_string(i), vec3(float(i % 40) * 3.0f, 0, float(i / 40) * 3.0f), 2.2f, 10.0f));
    }
    assignShadowmaskChannels(scene, MixedLightingMode::Shadowmask);
    int mixed = 0;
    for (const Light& light : scene.lights) mixed += light.baking.occlusionMaskChannel >= 0 ? 1 : 0;
    EXPECT_GT(mixed, 900);
}

TEST(ChannelsS9, LightsWithoutShadowsNeedNoChannel)
{
    Scene scene;
    for (int i = 0; i < 6; ++i) scene.lights.push_back(pointAt("p" + std::to_string(i), vec3(0), 5.0f));
    scene.lights[1].castShadows = false;
    scene.lights[2].shadowStrength = 0.0f;
    assignShadowmaskChannels(scene, MixedLightingMode::Shadowmask);
    for (const Light& light : scene.lights) EXPECT_EQ(light.baking.bakeType, LightMode::Mixed) << light.name;
    EXPECT_EQ(scene.lights[1].baking.occlusionMaskChannel, -1);
    EXPECT_EQ(scene.lights[2].baking.occlusionMaskChannel, -1);
}

TEST(ChannelsS25, SubtractiveGivesChannelZeroToTheBrightestSun)
{
    Scene scene;
    scene.lights = {makeLight(LightType::Directional, vec3(0), vec3(0, -1, 0), 1.0f, LightMode::Mixed),
                    makeLight(LightType::Directional, vec3(0), vec3(0, -1, 0), 3.0f, LightMode::Mixed),
                    makeLight(LightType::Directional, vec3(0), vec3(0, -1, 0), 9.0f, LightMode::Realtime),
                    pointAt("p", vec3(0), 3.0f)};
    assignShadowmaskChannels(scene, MixedLightingMode::Subtractive);
    EXPECT_EQ(scene.lights[0].baking.occlusionMaskChannel, -1);
    EXPECT_EQ(scene.lights[1].baking.occlusionMaskChannel, 0);
    EXPECT_EQ(scene.lights[2].baking.occlusionMaskChannel, -1);
    EXPECT_EQ(scene.lights[3].baking.occlusionMaskChannel, -1);
    EXPECT_FALSE(scene.lights[2].baking.isBaked);
}

} // namespace
} // namespace halflight::test::channel_assignment_test
