// Many lights of short range: their cost is that of the texels within reach, and their light adds up (spec S6, S9).
#include "bake/area_light_scene.h"
#include "bake/geometry/indices.h"
#include "bake/test_scene.h"
#include "transport/sample/light_reach.h"
#include "transport/shadows/texel_runs.h"

#include "halflight/shading/color.h"
#include "halflight/shading/random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace halflight::many_lights_test {
namespace {

using namespace test;

constexpr int kPage = 128;

/// Numbers from 0 to 1, one after the other.
struct Numbers {
    uint32_t state = 7;
    float next() { return unitFloat(state = hashPcg(state)); }
};

std::vector<PunctualLight> randomLights(int count, float range)
{
    Numbers numbers;
    std::vector<PunctualLight> lights;
    for (int i = 0; i < count; ++i) {
        PunctualLight light;
        light.position = 40.0f * vec3(numbers.next(), 0.2f * numbers.next(), numbers.next());
        light.colorIntensity = vec3(1.0f);
        light.range = range * (0.5f + numbers.next());
        if (i % 5 == 0) {
            light.type = shading::kLightSpot;
            light.axis = vec3(0, -1, 0);
            light.spotConstants = shading::spotConstants(0.3f, 0.6f);
        }
        lights.push_back(light);
    }
    return lights;
}

/// The tree returns the same light as a linear search: near, far, and at the end of ranges.
TEST(LightReachS9, FindsWhatTheListFinds)
{
    for (const int count : {0, 1, 3, 40, 500}) {
        std::vector<PunctualLight> lights = randomLights(count, 4.0f);
        if (count == 40) lights[17].range = 0.0f; // everywhere
        std::vector<const PunctualLight*> list;
        for (const PunctualLight& light : lights) list.push_back(&light);
        const LightReach reach(list);
        Numbers numbers{99};
        for (int i = 0; i < 4000; ++i) {
            vec3 point = 44.0f * vec3(numbers.next(), 0.2f * numbers.next(), numbers.next()) - 2.0f;
            if (count > 0 && i % 4 == 0) { // just within a range
                const PunctualLight& light = lights[std::size_t(i) % lights.size()];
                point = light.position + vec3(0, 0, light.range * 0.99999f);
            }
            const auto first =
                std::find_if(list.begin(), list.end(), [&](const PunctualLight* l) { return l->reaches(point); });
            ASSERT_EQ(reach.at(point), first == list.end() ? nullptr : *first) << count;
        }
    }
}

/// Stages that ask for the lights near a point or a box get all that reach it, and not the whole list.
TEST(LightReachS9, FindsAllNearAndFewOthers)
{
    std::vector<PunctualLight> lights = randomLights(5000, 2.0f);
    lights[17].range = 0.0f; // everywhere
    std::vector<const PunctualLight*> list;
    for (const PunctualLight& light : lights) list.push_back(&light);
    const LightReach reach(list);
    Numbers numbers{5};
    for (int i = 0; i < 200; ++i) {
        Bounds box;
        box.extend(44.0f * vec3(numbers.next(), 0.2f * numbers.next(), numbers.next()) - 2.0f);
        std::vector<uint32_t> visited;
        reach.each(box.min, [&](uint32_t number) { visited.push_back(number); });
        const std::vector<const PunctualLight*> ofPoint = reach.near(std::span(&box, 1));
        std::size_t reached = 0;
        for (uint32_t l = 0; l < lights.size(); ++l) {
            if (!lights[l].reaches(box.min)) continue;
            ++reached;
            ASSERT_EQ(std::count(visited.begin(), visited.end(), l), 1);
            ASSERT_EQ(std::count(ofPoint.begin(), ofPoint.end(), list[l]), 1);
        }
        EXPECT_LT(visited.size(), 8 * reached + 100) << "of 5,000";
        box.extend(box.min + vec3(1.0f, 0.5f, 2.0f));
        const std::vector<const PunctualLight*> ofBox = reach.near(std::span(&box, 1));
        for (int k = 0; k < 20; ++k) {
            const vec3 point = box.min + box.size() * vec3(numbers.next(), numbers.next(), numbers.next());
            for (const PunctualLight* light : list)
                if (light->reaches(point)) {
                    ASSERT_EQ(std::count(ofBox.begin(), ofBox.end(), light), 1);
                }
        }
    }
}

/// A floor 32 m wide under `count` lights that are 2 m above it and reach 3 m, and a wall across it.
Scene makeFloor(int count)
{
    Scene scene;
    const int black = addMaterial(scene, vec3(0.0f), vec3(0.0f), true);
    addRectangle(scene, {vec3(-16, 0, 16), vec3(32, 0, 0), vec3(0, 0, -32)}, black, kPage, {vec2(2), vec2(98)});
    Numbers numbers;
    for (int i = 0; i < count; ++i) {
        const vec3 place(30.0f * numbers.next() - 15.0f, 2.0f, 30.0f * numbers.next() - 15.0f);
        Light light = makeLight(LightType::Point, place, vec3(0, -1, 0), 10.0f, LightMode::Baked);
        light.rangeMeters = 3.0f;
        scene.lights.push_back(light);
    }
    return scene;
}

IntegrationSettings directOnly()
{
    IntegrationSettings settings;
    settings.samples = 16;
    settings.bounces = 0;
    settings.shadowSamples = 16;
    return settings;
}

TEST(ManyLightsS6, TheFloorHasTheLightOfAllThatReachIt)
{
    Bench bench(makeFloor(150), MixedLightingMode::Shadowmask, kPage, directOnly());
    const std::vector<IrradianceEstimate> estimates = bench.irradiance();
    double worst = 0.0;
    double brightest = 0.0;
    for (std::size_t i = 0; i < estimates.size(); ++i) {
        // The mean over the texel: at the end of a range light changes within one texel.
        const vec3 center = bench.positionOf(bench.map.texels[i]);
        double expected = 0.0;
        for (const Light& light : bench.scene.lights) {
            for (int k = 0; k < 16; ++k) {
                const vec3 p = center + vec3(float(k % 4) - 1.5f, 0.0f, float(k / 4) - 1.5f) / 12.0f;
                const vec3 way = light.position() - p;
                const double d2 = double(glm::dot(way, way));
                const double window = std::max(0.0, 1.0 - d2 * d2 / 81.0);
                expected += 10.0 * window / d2 * double(way.y) / std::sqrt(d2) / 16.0;
            }
        }
        worst = std::max(worst, std::abs(double(estimates[i].irradiance.x) - expected));
        brightest = std::max(brightest, expected);
    }
    EXPECT_GT(brightest, 2.0);
    EXPECT_LT(worst, 0.02 * brightest);
}

/// Area lights without a range, close and far, some of them cut by the floor's horizon: light and its mean direction.
TEST(ManyLightsS6, AreaLightsAtEveryDistanceAreThoseOfBruteForce)
{
    Scene scene;
    const int black = addMaterial(scene, vec3(0.0f), vec3(0.0f), true);
    addRectangle(scene, {vec3(-2, 0, 2), vec3(4, 0, 0), vec3(0, 0, -4)}, black, kPage, {vec2(2), vec2(98)});
    Numbers numbers;
    for (int i = 0; i < 40; ++i) {
        const float height = 0.15f * std::exp2(6.0f * numbers.next()); // 0.15 to 10 m; half sides are 0.1 to 0.2 m
        const vec3 place(3.0f * numbers.next() - 1.5f, height, 3.0f * numbers.next() - 1.5f);
        const vec3 direction = i % 4 == 0 ? vec3(1, -0.05f, 0) : vec3(numbers.next() - 0.5f, -1, numbers.next() - 0.5f);
        const LightType type = i % 2 == 0 ? LightType::Rectangle : LightType::Disk;
        const vec2 size(0.2f + 0.2f * numbers.next(), 0.2f);
        scene.lights.push_back(areaLight(type, place, glm::normalize(direction), size, 100.0f, LightMode::Baked));
        scene.lights.back().castShadows = false;
    }
    Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, directOnly());
    const std::vector<IrradianceEstimate> estimates = bench.irradiance();
    double off = 0.0;
    double count = 0.0;
    for (std::size_t i = 0; i < estimates.size(); i += 97) {
        const vec3 p = bench.positionOf(bench.map.texels[i]);
        if (std::max(std::abs(p.x), std::abs(p.z)) > 1.9f) continue;
        double irradiance = 0.0;
        glm::dvec3 moment(0.0);
        for (const Light& light : bench.scene.lights) {
            forPieces(light, p, 40, [&](vec3, vec3 direction, double solidAngle) {
                const double lux = 100.0 * std::max(double(direction.y), 0.0) * solidAngle;
                irradiance += lux;
                moment += lux * glm::dvec3(direction);
            });
        }
        const double error = std::abs(double(estimates[i].irradiance.x) - irradiance) / irradiance;
        EXPECT_LT(error, 0.03) << p.x << " " << p.z; // texels are 4 cm wide, under lights at 15 cm
        EXPECT_LT(glm::length(glm::dvec3(estimates[i].moment) - moment) / irradiance, 0.03) << p.x << " " << p.z;
        off += error;
        count += 1.0;
    }
    EXPECT_GT(count, 70.0);
    EXPECT_LT(off / count, 0.006);
}

/// Ten times the lights on ten times the floor cost ten times as many shadow rays, not a hundred times.
TEST(ManyLightsS6, RaysFollowTheTexelsInReach)
{
    const auto raysOf = [](int lights) {
        Bench bench(makeFloor(lights), MixedLightingMode::Shadowmask, kPage, directOnly());
        bench.irradiance();
        return double(bench.integrator->raysTraced());
    };
    const double none = raysOf(0);
    const double few = (raysOf(10) - none) / 10.0;
    const double many = (raysOf(200) - none) / 200.0;
    EXPECT_GT(few, 1000.0);
    EXPECT_LT(many, 1.5 * few);
    EXPECT_GT(many, 0.5 * few);

    // A light of 3 m range reaches 254 of the 9,216 texels of a floor of 32 m.
    Bench bench(makeFloor(1), MixedLightingMode::Shadowmask, kPage, directOnly());
    const std::vector<uint32_t> all = allIndices(bench.map.texels.size());
    const TexelRuns runs(bench.geometry, bench.map, all);
    const std::vector<PunctualLight> lights = punctualLights(bench.scene, LightUse::Bake);
    const PunctualLight* one = lights.data();
    const std::vector<uint32_t> reached = runs.reachedBy(std::span(&one, 1), 0, runs.size());
    EXPECT_LT(reached.size(), 1500u);
    std::size_t inReach = 0;
    for (std::size_t i = 0; i < bench.map.texels.size(); ++i) {
        if (!lights[0].reaches(bench.positionOf(bench.map.texels[i]))) continue;
        ++inReach;
        EXPECT_TRUE(std::binary_search(reached.begin(), reached.end(), uint32_t(i)));
    }
    EXPECT_GT(inReach, 100u);
}

} // namespace
} // namespace halflight::many_lights_test
