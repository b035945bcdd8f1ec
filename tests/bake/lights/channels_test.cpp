// Lights without a range: how far their baked shadows reach, so that channels suffice (spec section 4).

#include "bake/lights/channels.h"
#include "bake/test_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace halflight::test::channels_test {
namespace {

constexpr int kPage = 64;

Light lamp(const std::string& name, vec3 position, float range = 0.0f, float candela = 1000.0f)
{
    Light light = makeLight(LightType::Point, position, vec3(0, -1, 0), candela, LightMode::Mixed);
    light.name = name;
    light.rangeMeters = range;
    return light;
}

void addFloor(Scene& scene, float x0, float x1, float halfZ)
{
    addRectangle(scene, {vec3(x0, 0, halfZ), vec3(x1 - x0, 0, 0), vec3(0, 0, -2.0f * halfZ)},
                 addMaterial(scene, vec3(0.5f)), kPage, {vec2(1), vec2(63)});
}

/// Six lamps without a range, 36 m apart, 5 m above a street.
Scene street(float height = 5.0f, float halfWidth = 20.0f)
{
    Scene scene;
    addFloor(scene, -20.0f, 200.0f, halfWidth);
    for (int i = 0; i < 6; ++i)
        scene.lights.push_back(lamp("lamp " + std::to_string(i), vec3(36.0f * float(i), height, 0)));
    return scene;
}

/// Within reach and cone of what the bake recorded.
bool baked(const Light& light, vec3 point)
{
    if (light.type == LightType::Directional) return true;
    const vec3 offset = point - light.position();
    const float distance = glm::length(offset);
    if (light.baking.reachMeters > 0.0f && distance > light.baking.reachMeters) return false;
    return light.type != LightType::Spot ||
           glm::dot(offset, light.direction()) >= std::cos(light.baking.outerConeRadians) * distance;
}

/// No point is within reach of two lights that share a channel: points near the line between them and at random.
void expectNoSharedPlace(const Scene& scene, std::mt19937& random, float size)
{
    std::normal_distribution<float> normal;
    for (std::size_t i = 0; i < scene.lights.size(); ++i) {
        for (std::size_t j = i + 1; j < scene.lights.size(); ++j) {
            const Light& a = scene.lights[i];
            const Light& b = scene.lights[j];
            if (a.baking.occlusionMaskChannel < 0 || a.baking.occlusionMaskChannel != b.baking.occlusionMaskChannel)
                continue;
            int both = 0;
            for (int k = 0; k < 3000; ++k) {
                const float along = std::uniform_real_distribution<float>(-0.2f, 1.2f)(random);
                const float spread =
                    k % 3 == 0 ? size : 0.1f * float(k % 7) * glm::distance(a.position(), b.position());
                const vec3 p = glm::mix(a.position(), b.position(), along) +
                               spread * vec3(normal(random), normal(random), normal(random));
                both += baked(a, p) && baked(b, p);
            }
            EXPECT_EQ(both, 0) << a.name << " and " << b.name << " share channel " << a.baking.occlusionMaskChannel;
        }
    }
}

TEST(ReachS9, SixLampsWithoutRangeKeepTheirMasks)
{
    for (const float height : {3.0f, 5.0f, 8.0f}) {
        for (const float halfWidth : {5.0f, 20.0f, 100.0f}) {
            SCOPED_TRACE(testing::Message() << height << " m high, " << 2 * halfWidth << " m wide");
            Scene scene = street(height, halfWidth);
            assignShadowmaskChannels(scene, MixedLightingMode::Shadowmask);
            std::mt19937 random(1);
            for (const Light& light : scene.lights) {
                EXPECT_EQ(light.baking.bakeType, LightMode::Mixed) << light.name << " " << light.baking.reason;
                EXPECT_GE(light.baking.occlusionMaskChannel, 0) << light.name;
                if (light.baking.reachMeters > 0.0f) {
                    EXPECT_GT(light.baking.reachMeters, 36.0f) << light.name << " keeps less than its own stretch";
                }
            }
            expectNoSharedPlace(scene, random, 40.0f);
        }
    }
}

/// A reach ends where the light is at most a twentieth of the level that the brightest tenth of the others' light
/// exceeds. Truth: a fine grid over the floor.
TEST(ReachS9, EndsWhereTheLightIsLittleBesideTheOthers)
{
    Scene scene = street();
    assignShadowmaskChannels(scene, MixedLightingMode::Shadowmask);
    int ended = 0;
    for (const Light& light : scene.lights) {
        if (light.baking.reachMeters <= 0.0f) continue;
        ++ended;
        std::vector<double> levels;
        for (int x = 0; x < 880; ++x) {
            for (int z = 0; z < 160; ++z) {
                const vec3 p(-20.0f + 0.25f * (float(x) + 0.5f), 0.0f, -20.0f + 0.25f * (float(z) + 0.5f));
                double sum = 0.0;
                for (const Light& other : scene.lights) {
                    if (&other == &light) continue;
                    const vec3 d = other.position() - p;
                    sum += 1000.0 / double(glm::dot(d, d));
                }
                levels.push_back(sum);
            }
        }
        std::sort(levels.rbegin(), levels.rend());
        double all = 0.0;
        for (const double level : levels) all += level;
        double brightest = 0.0;
        std::size_t n = 0;
        while (brightest < 0.1 * all) brightest += levels[n++];
        const double share = 1000.0 / std::pow(double(light.baking.reachMeters), 2.0) / levels[n - 1];
        EXPECT_LT(share, 1.05 / 20.0) << light.name;
        EXPECT_GT(share, 0.95 / 320.0) << light.name;
    }
    EXPECT_GE(ended, 2) << "six lamps need a shared channel";
}

TEST(ReachS9, IsUnlimitedWhileChannelsSuffice)
{
    Scene scene = street();
    scene.lights.resize(4);
    assignShadowmaskChannels(scene, MixedLightingMode::Shadowmask);
    for (const Light& light : scene.lights) {
        EXPECT_GE(light.baking.occlusionMaskChannel, 0);
        EXPECT_EQ(light.baking.reachMeters, 0.0f) << light.name;
    }
    // Lights that have a range keep it, whatever the others need.
    scene = street();
    for (std::size_t i = 0; i < 3; ++i) scene.lights[i].rangeMeters = 30.0f;
    assignShadowmaskChannels(scene, MixedLightingMode::Shadowmask);
    for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(scene.lights[i].baking.reachMeters, 30.0f);
}

/// A sun may be dimmed at run time: it must not cut short the lamps' shadows.
TEST(ReachS9, DoesNotDependOnTheSun)
{
    Scene night = street();
    Scene day = street();
    Light sun = makeLight(LightType::Directional, vec3(0), vec3(0.3f, -1, 0.2f), 1.0e5f, LightMode::Realtime);
    day.lights.push_back(sun);
    assignShadowmaskChannels(night, MixedLightingMode::Shadowmask);
    assignShadowmaskChannels(day, MixedLightingMode::Shadowmask);
    for (std::size_t i = 0; i < night.lights.size(); ++i)
        EXPECT_EQ(night.lights[i].baking.reachMeters, day.lights[i].baking.reachMeters);
}

TEST(ReachS9, NoTwoLightsOfAChannelReachOnePlace)
{
    std::mt19937 random(11);
    int ended = 0;
    for (int trial = 0; trial < 40; ++trial) {
        SCOPED_TRACE(trial);
        Scene scene;
        addFloor(scene, -80.0f, 80.0f, 80.0f);
        std::uniform_real_distribution<float> u(-80.0f, 80.0f);
        std::uniform_real_distribution<float> unit(0.0f, 1.0f);
        for (int i = 0; i < 10; ++i) {
            Light light = lamp("lamp " + std::to_string(i), vec3(u(random), 2.0f + 4.0f * unit(random), u(random)),
                               unit(random) < 0.6f ? 0.0f : 5.0f + 40.0f * unit(random), std::exp(7.0f * unit(random)));
            if (unit(random) < 0.4f) {
                light.type = LightType::Spot;
                light.outerConeRadians = 0.2f + 1.2f * unit(random);
                light.worldFromLight = lightPose(light.position(), vec3(u(random), -40.0f * unit(random), u(random)));
            }
            scene.lights.push_back(light);
        }
        assignShadowmaskChannels(scene, MixedLightingMode::Shadowmask);
        for (const Light& light : scene.lights) {
            EXPECT_EQ(light.baking.occlusionMaskChannel >= 0, light.baking.bakeType == LightMode::Mixed);
            if (light.rangeMeters > 0.0f) {
                EXPECT_EQ(light.baking.reachMeters, light.rangeMeters);
            } else {
                ended += light.baking.reachMeters > 0.0f;
            }
        }
        expectNoSharedPlace(scene, random, 60.0f);
    }
    EXPECT_GT(ended, 20) << "the test sees few effective reaches";
}

TEST(ReachS10, AnOverflowNamesTheCure)
{
    Scene scene;
    addFloor(scene, -5.0f, 5.0f, 5.0f);
    for (int i = 0; i < 5; ++i)
        scene.lights.push_back(lamp("lamp " + std::to_string(i), vec3(float(i), 3, 0), i == 1 ? 20.0f : 0.0f));
    assignShadowmaskChannels(scene, MixedLightingMode::Shadowmask);
    int overflown = 0;
    for (const Light& light : scene.lights) {
        if (light.baking.bakeType != LightMode::Baked) continue;
        ++overflown;
        EXPECT_NE(light.baking.reason.find("hold all shadowmask channels"), std::string::npos);
        EXPECT_NE(light.baking.reason.find("a range (halflight_range"), std::string::npos) << light.baking.reason;
        EXPECT_EQ(light.baking.reachMeters, light.rangeMeters);
    }
    EXPECT_EQ(overflown, 1);
}

/// The mask of a shared channel is that of the light in reach: a wall between the first two lamps hides the ground
/// behind it from each, and nothing else.
TEST(ReachS9, AMaskHoldsTheLightInReach)
{
    Scene scene = street(5.0f, 2.0f);
    const float wall = 18.0f;
    addRectangle(scene, {vec3(wall, 0, 50), vec3(0, 40, 0), vec3(0, 0, -100)},
                 addMaterial(scene, vec3(0.5f), vec3(0.0f), true), kPage);
    Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, {});
    const std::vector<Light>& lights = bench.scene.lights;
    ASSERT_TRUE(std::any_of(lights.begin(), lights.end(), [](const Light& l) { return l.baking.reachMeters > 0.0f; }));
    bench.irradiance();
    const std::vector<vec4> mask = bench.shadowmask();
    int shadowed = 0;
    for (std::size_t t = 0; t < mask.size(); ++t) {
        const float x = bench.positionOf(bench.map.texels[t]).x;
        if (std::abs(x - wall) < 4.0f) continue; // a texel is 3.5 m long
        for (const Light& light : lights) {
            ASSERT_GE(light.baking.occlusionMaskChannel, 0);
            const float reach = light.baking.reachMeters > 0.0f ? light.baking.reachMeters : kInfinity;
            if (glm::length(vec2(x - light.position().x, 7.0f)) > reach - 4.0f) continue;
            const bool hidden = (x < wall) != (light.position().x < wall);
            shadowed += hidden;
            EXPECT_EQ(mask[t][light.baking.occlusionMaskChannel], hidden ? 0.0f : 1.0f) << light.name << ", x " << x;
        }
    }
    EXPECT_GT(shadowed, 100);
}

} // namespace
} // namespace halflight::test::channels_test
