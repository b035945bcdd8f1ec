// How many shadow rays texels get (spec S8).

#include "bake/test_scene.h"
#include "bake_cpu/trace/embree_kernels.h"
#include "transport/sample/path_tracer.h"

#include "halflight/shading/sampling.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <utility>

namespace halflight::test::shadow_rays_test {
namespace {

constexpr int kPage = 64;

/// Where the first shadow rays agree the others are left out, and the mask is that of all rays.
TEST(ShadowmaskS8, DecidedTexelsAreRight)
{
    Scene scene;
    const int black = addMaterial(scene, vec3(0), vec3(0), true);
    addRectangle(scene, {vec3(-2, 0, 2), vec3(4, 0, 0), vec3(0, 0, -4)}, black, kPage, {vec2(1), vec2(63)});
    addBox(scene, vec3(-0.5f, 0.3f, -0.5f), vec3(0.5f, 1.1f, 0.5f), black, false);
    // A pole half a texel thick.
    addBox(scene, vec3(1.0f, 0.2f, 0.5f), vec3(1.032f, 1.5f, 0.532f), black, false);
    scene.lights.push_back(makeLight(LightType::Point, vec3(0.3f, 3, 0), vec3(0, -1, 0), 1.0f, LightMode::Mixed));
    scene.lights[0].radiusMeters = 0.05f;
    IntegrationSettings settings;
    settings.shadowSamples = 256;
    settings.bounces = 0;
    Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, settings);
    const uint64_t before = bench.integrator->raysTraced();
    const auto mask = bench.shadowmask();
    const auto perTexel = double(bench.integrator->raysTraced() - before) / double(mask.size());
    EXPECT_LT(perTexel, 0.5 * 256);
    const PathTracer paths(bench.scene, bench.geometry, LightUse::Bake, Bounces::Diffuse, embreeKernels());
    double squares = 0.0;
    for (std::size_t i = 0; i < mask.size(); ++i) {
        std::array<SurfacePoint, kMaxTexelPoints> points;
        const int count = texelPoints(bench.geometry, bench.map, bench.map.texels[i], points);
        double sum = 0.0;
        uint64_t rays = 0;
        constexpr int kSamples = 512;
        for (int s = 0; s < kSamples; ++s) {
            Sampler sampler(99, uint32_t(i), uint32_t(s));
            sum += double(paths.direct()
                              .lightVisibility(paths.light().lights()[0], points[std::size_t(s % count)],
                                               shading::sampleDisc(sampler.next2()), rays)
                              .x);
        }
        squares += std::pow(sum / kSamples - double(mask[i].x), 2.0);
    }
    EXPECT_LT(std::sqrt(squares / double(mask.size())), 0.02);
}

/// A scene under a light from straight above that has a mask and no size.
Bench benchUnderSun(Scene scene, int shadowSamples)
{
    scene.lights.push_back(makeLight(LightType::Directional, vec3(0), vec3(0, -1, 0), 1.0f, LightMode::Mixed));
    IntegrationSettings settings;
    settings.shadowSamples = shadowSamples;
    settings.bounces = 0;
    return {std::move(scene), MixedLightingMode::Shadowmask, kPage, settings};
}

/// On a chart of four texels few rays agree by chance: all of them are traced.
TEST(ShadowmaskS8, SmallChartsGetAllTheirRays)
{
    constexpr int kCharts = 24;
    Scene scene;
    const int black = addMaterial(scene, vec3(0), vec3(0), true);
    const auto litShare = [](int i) { return (float(i) + 0.5f) / float(kCharts); };
    for (int i = 0; i < kCharts; ++i) {
        const vec3 corner(float(i), 0, 0);
        const vec2 place(2.0f + 8.0f * float(i % 7), 2.0f + 8.0f * float(i / 7));
        addRectangle(scene, {corner, vec3(0.2f, 0, 0), vec3(0, 0, -0.2f)}, black, kPage, {place, place + 2.0f});
        addRectangle(scene, {corner + vec3(0.2f * litShare(i), 1.0f, 0.1f), vec3(0.5f, 0, 0), vec3(0, 0, -0.4f)}, black,
                     kPage);
    }
    Bench bench = benchUnderSun(std::move(scene), 256);
    const auto mask = bench.shadowmask();
    std::array<float, kCharts> sum{};
    std::array<int, kCharts> count{};
    for (std::size_t i = 0; i < mask.size(); ++i) {
        const auto chart = std::size_t(bench.positionOf(bench.map.texels[i]).x);
        sum[chart] += mask[i].x;
        ++count[chart];
    }
    for (int i = 0; i < kCharts; ++i) {
        ASSERT_EQ(count[std::size_t(i)], 4);
        EXPECT_NEAR(sum[std::size_t(i)] / 4.0f, litShare(i), 0.03f) << "chart " << i;
    }
}

/// Texels on a shadow's edge get more rays than are asked for: at 16, no texel of a slanting edge without penumbra is
/// off by more than three of its 32, and most by hardly more than one.
TEST(ShadowmaskS8, EdgesGetMoreRays)
{
    struct Case {
        int samples;
        int texels; ///< across the floor
        float tolerance;
        float meanSquare; ///< its root
        int leastOnEdge;
    };
    // Sums hold the largest number of rays too.
    for (const Case& c : {Case{16, 60, 4.0f / 32.0f, 0.042f, 50}, {65536, 12, 0.005f, 0.003f, 10}}) {
        Scene scene;
        const int black = addMaterial(scene, vec3(0), vec3(0), true);
        addRectangle(scene, {vec3(-2, 0, 2), vec3(4, 0, 0), vec3(0, 0, -4)}, black, kPage,
                     {vec2(2), vec2(2 + c.texels)});
        // Its edge runs through the origin at a slope of a third.
        addRectangle(scene, {vec3(-9, 1, 3), vec3(18, 0, -6), vec3(0, 0, -9)}, black, kPage);
        Bench bench = benchUnderSun(std::move(scene), c.samples);
        const auto mask = bench.shadowmask();
        int onEdge = 0;
        float squares = 0.0f;
        for (std::size_t i = 0; i < mask.size(); ++i) {
            const Texel& texel = bench.map.texels[i];
            int lit = 0;
            constexpr int kSide = 64;
            for (int s = 0; s < kSide * kSide; ++s) {
                const vec2 at = (vec2(s % kSide, s / kSide) + 0.5f) / float(kSide);
                const vec2 p =
                    (vec2(texel.x, texel.y) + at - 2.0f) * (4.0f / float(c.texels)) - 2.0f; // z runs down the page
                lit += -p.y > -p.x / 3.0f ? 1 : 0;
            }
            const float truth = float(lit) / float(kSide * kSide);
            onEdge += lit > 0 && lit < kSide * kSide ? 1 : 0;
            squares += (mask[i].x - truth) * (mask[i].x - truth);
            EXPECT_NEAR(mask[i].x, truth, c.tolerance) << c.samples << " samples, " << texel.x << ", " << texel.y;
        }
        EXPECT_GT(onEdge, c.leastOnEdge);
        EXPECT_LT(std::sqrt(squares / float(onEdge)), c.meanSquare);
    }
}

/// A shadow along a row of texels at a chart's rim, narrower than a texel, is found wherever its edge is. So is one
/// that covers nearly the whole row.
TEST(ShadowmaskS8, EdgesAlongRowsOfTexelsAreFound)
{
    constexpr int kTexels = 40;
    constexpr float kTexel = 4.0f / float(kTexels);
    for (const float dark : {0.07f, 0.1f, 0.2f, 0.8f, 0.9f, 0.93f}) {
        Scene scene;
        const int black = addMaterial(scene, vec3(0), vec3(0), true);
        addRectangle(scene, {vec3(-2, 0, 2), vec3(4, 0, 0), vec3(0, 0, -4)}, black, kPage,
                     {vec2(2), vec2(2 + kTexels)});
        // The sun is overhead. The roof's edge is so far from the floor's rim, and the roof beyond the rim, or over all
        // else.
        const bool most = dark > 0.5f;
        const float edge = -2.0f + (most ? 1.0f - dark : dark) * kTexel;
        const float begin = most ? 9.0f : edge;
        const float end = most ? edge : -11.0f;
        addRectangle(scene, {vec3(-9, 1, begin), vec3(18, 0, 0), vec3(0, 0, end - begin)}, black, kPage);
        Bench bench = benchUnderSun(std::move(scene), 64);
        const auto mask = bench.shadowmask();
        double sum = 0.0;
        int count = 0;
        for (std::size_t i = 0; i < mask.size(); ++i) {
            if (bench.positionOf(bench.map.texels[i]).z > -2.0f + kTexel) continue;
            sum += double(mask[i].x);
            ++count;
        }
        EXPECT_EQ(count, kTexels);
        EXPECT_NEAR(sum / count, 1.0 - double(dark), 0.015) << dark;
    }
}

} // namespace
} // namespace halflight::test::shadow_rays_test
