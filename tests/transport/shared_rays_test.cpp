// Shadow rays that many lights share: the light is that of all lights, the rays are those of a few (spec S6, S14).
#include "bake/area_light_scene.h"
#include "bake/seeds.h"
#include "bake/test_scene.h"
#include "transport/sample/share_rays.h"

#include "halflight/shading/brdf_sampling.h"
#include "halflight/shading/random.h"
#include "halflight/shading/sh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace halflight::shared_rays_test {
namespace {

using namespace test;

constexpr int kPage = 64;
constexpr int kLights = 300;
constexpr float kNits = 100.0f;
constexpr float kCandela = 4.0f;

/// Numbers from 0 to 1, one after the other.
struct Numbers {
    uint32_t state = 11;
    float next() { return unitFloat(state = hashPcg(state)); }
};

TEST(SharedRaysS6, ExpectationIsTheSumAndRaysAreFew)
{
    Numbers numbers;
    std::vector<float> weights;
    for (int i = 0; i < 200; ++i) weights.push_back(i % 7 == 0 ? 0.0f : std::exp2(12.0f * numbers.next()));
    constexpr int kEach = 3;
    constexpr std::size_t kMost = 20;
    constexpr int kTimes = 200000;
    std::vector<double> estimates(weights.size(), 0.0);
    for (int t = 0; t < kTimes; ++t) {
        int all = 0;
        shareRays(weights, kEach, kMost, (float(t) + 0.5f) / float(kTimes), [&](std::size_t i, int rays, float scale) {
            all += rays;
            estimates[i] += double(scale) / double(kTimes);
        });
        ASSERT_NEAR(all, kEach * int(kMost), 1);
    }
    for (std::size_t i = 0; i < weights.size(); ++i)
        EXPECT_NEAR(estimates[i], weights[i] > 0.0f ? 1.0 : 0.0, 0.02) << i << " of weight " << weights[i];

    int few = 0;
    shareRays(std::span(weights).first(kMost), kEach, kMost, 0.5f, [&](std::size_t, int rays, float scale) {
        EXPECT_EQ(rays, kEach);
        EXPECT_EQ(scale, 1.0f);
        ++few;
    });
    EXPECT_EQ(few, int(kMost));
}

/// A black wall at x = 0 and a black metal floor of which only lights shine, half of them behind the wall. Every third
/// light has an area.
Scene makeHall()
{
    Scene scene;
    const int black = addMaterial(scene, vec3(0.0f), vec3(0.0f), true);
    const int metal = addMaterial(scene, vec3(1.0f));
    scene.materials[std::size_t(metal)].metallic = 1.0f;
    scene.materials[std::size_t(metal)].roughness = 0.4f;
    addRectangle(scene, {vec3(-4, 0, 4), vec3(8, 0, 0), vec3(0, 0, -8)}, metal, kPage, {vec2(2), vec2(40)});
    addRectangle(scene, {vec3(0, 0, 4), vec3(0, 0, -8), vec3(0, 8, 0)}, black, kPage);
    Numbers numbers;
    for (int i = 0; i < kLights; ++i) {
        const vec3 place(7.8f * numbers.next() - 3.9f, 1.0f + 3.0f * numbers.next(), 7.8f * numbers.next() - 3.9f);
        const vec3 down(0.6f * numbers.next() - 0.3f, -1, 0.6f * numbers.next() - 0.3f);
        if (std::abs(place.x) < 0.3f) continue; // none is in the wall
        if (i % 3 == 0) {
            const LightType type = i % 2 == 0 ? LightType::Rectangle : LightType::Disk;
            scene.lights.push_back(areaLight(type, place, down, vec2(0.3f, 0.2f), kNits, LightMode::Baked));
        } else {
            scene.lights.push_back(makeLight(LightType::Point, place, down, kCandela, LightMode::Baked));
        }
    }
    return scene;
}

/// Calls visit(direction, lux) for what arrives at a point on the positive side of the wall, by brute force.
template<typename Visit> void forArriving(const Scene& scene, vec3 from, const Visit& visit)
{
    for (const Light& light : scene.lights) {
        if (light.position().x < 0.0f) continue;
        if (light.type != LightType::Point) {
            forPieces(light, from, 50,
                      [&](vec3, vec3 direction, double solidAngle) { visit(direction, float(solidAngle) * kNits); });
        } else {
            const vec3 way = light.position() - from;
            visit(glm::normalize(way), kCandela / glm::dot(way, way));
        }
    }
}

TEST(SharedRaysS14, ProbesHaveTheLightOfAllLights)
{
    const vec3 position(1.5f, 0.7f, 0.5f);
    const Scene scene = makeHall();
    SphericalHarmonicsL2 expected{};
    forArriving(scene, position, [&](vec3 direction, float lux) {
        for (int i = 0; i < 9; ++i) expected[std::size_t(i)] += vec3(lux * shading::shBasis(i, direction));
    });
    std::vector<SphericalHarmonicsL2> found;
    for (uint32_t seed = 1; seed <= 16; ++seed) {
        IntegrationSettings settings;
        settings.seed = seed;
        settings.bounces = 0;
        settings.shadowSamples = 16;
        Bench bench(scene, MixedLightingMode::Shadowmask, kPage, settings);
        std::vector<ProbeEstimate> out(1);
        const uint64_t before = bench.integrator->raysTraced();
        EXPECT_TRUE(bench.integrator->probes(std::vector{position}, std::vector{0u}, 16, out, {}));
        EXPECT_LT(bench.integrator->raysTraced() - before, 64u * 16u + 16u * 4u) << "for " << scene.lights.size();
        found.push_back(out[0].radiance);
    }
    for (std::size_t i = 0; i < 9; ++i) {
        const SeedMean mean = overSeeds([&](uint32_t seed) { return found[seed - 1][i].y; }, 16);
        EXPECT_LT(kStandardErrors * mean.error, 0.02 * double(expected[0].y));
        EXPECT_NEAR(mean.mean, double(expected[i].y), kStandardErrors * mean.error + 1.0e-3 * double(expected[0].y));
    }
}

TEST(SharedRaysS6, HighlightsAreThoseOfAllLights)
{
    const Scene scene = makeHall();
    const std::vector<vec3> views{glm::normalize(vec3(1, 1, 0.2f)), glm::normalize(vec3(-0.2f, 0.3f, 1))};
    std::vector<std::vector<double>> found(views.size());
    SurfacePoint point;
    for (uint32_t seed = 1; seed <= 64; ++seed) {
        IntegrationSettings settings;
        settings.seed = seed;
        settings.bounces = 0;
        Bench bench(scene, MixedLightingMode::Shadowmask, kPage, settings);
        point = surfacePoint(bench.geometry, 0, vec2(0.25f, 0.35f));
        if (point.position.x <= 0.0f) point = surfacePoint(bench.geometry, 0, vec2(0.7f, 0.2f));
        std::vector<SpecularEstimate> out(1);
        const uint64_t before = bench.integrator->raysTraced();
        EXPECT_TRUE(bench.integrator->specularLight(std::span(&point, 1), views, out, {}));
        EXPECT_LT(bench.integrator->raysTraced() - before, views.size() * 12u * (4u + 2u));
        for (std::size_t v = 0; v < views.size(); ++v) found[v].push_back(double(out[0].radiance[v].y));
    }
    ASSERT_GT(point.position.x, 0.5f);
    for (std::size_t v = 0; v < views.size(); ++v) {
        double expected = 0.0;
        forArriving(scene, point.position, [&](vec3 direction, float lux) {
            expected += double(shading::reflectSpecular(vec3(1.0f), 1.0f, shading::ggxAlphaOf(0.4f), point.normal,
                                                        views[v], direction, vec3(lux))
                                   .y);
        });
        expectMean(meanOf(found[v]), expected, {0.3, 0.01});
    }
}

} // namespace
} // namespace halflight::shared_rays_test
