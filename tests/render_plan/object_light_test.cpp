// What an object gets of the probes or, without any, of the sky.
#include "halflight/shading/sh.h"
#include "halflight/shading/sky.h"
#include "probe_sets.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace halflight::object_light_test {
namespace {

using namespace test;

TEST(ProbesS14, OcclusionIsClamped)
{
    BakedScene baked = probeGrid({2, 2, 2}, [](vec3) { return 1.0f; });
    for (Probe& probe : baked.probes.probes) probe.occlusion.layers[0] = vec4(1.0001f, -0.5f, 7.0f, 0.5f);
    EXPECT_EQ(rawProbes(baked).sample({-1, 2, 5.3f}).occlusion[0], 1.0f);
    EXPECT_EQ(rawProbes(baked).sample({-1, 2, 5.3f}).occlusion[1], 0.0f);
    EXPECT_EQ(rawProbes(baked).sample({-1, 2, 5.3f}).occlusion[2], 1.0f);
    EXPECT_NEAR(rawProbes(baked).sample({-1, 2, 5.3f}).occlusion[3], 0.5f, 1.0e-6f);
}

TEST(ProbesS14, SpacingOfGridsAndLists)
{
    EXPECT_EQ(rawProbes(probeGrid({4, 3, 5}, linear)).spacingMeters(), kGridSpacing);
    EXPECT_EQ(rawProbes(probeGrid({4, 1, 5}, linear)).spacingMeters(), vec3(1.5f, kInfinity, 0.75f));
    BakedScene list = probeGrid({4, 4, 4}, linear);
    for (Probe& probe : list.probes.probes) probe.position = (probe.position - kGridOrigin) / kGridSpacing * 0.8f;
    list.probes.size = ivec3(0);
    EXPECT_LT(glm::length(rawProbes(list).spacingMeters() - vec3(0.8f)), 1.0e-5f);
}

TEST(ProbesS14, AnchorIsTheCenterOfTheBounds)
{
    BakedScene baked = emptyScene();
    addBox(baked, {3, 4, 5}, {1, 2, 0.5f}, false);
    const std::vector<Bounds> bounds = objectBounds(baked.scene);
    EXPECT_EQ(probeAnchor(baked.scene.objects[0], bounds[0]), vec3(3, 4, 5));
    EXPECT_EQ(probeAnchor(baked.scene.objects[0], Bounds{}), vec3(3, 4, 5)); // its origin
    const Bounds lopsided{{0, 0, 0}, {8, 2, 2}};
    EXPECT_EQ(probeAnchor(baked.scene.objects[0], lopsided), vec3(4, 1, 1));
}

// Interpolation leaves alone what all probes agree on, to the bit: channels without a light are 1.
TEST(ProbesS14, UnusedChannelsAreExactlyOne)
{
    const BakedScene baked = probeList(randomPoints(95, 100, vec3(0), vec3(5)), rough);
    const ProbeInterpolator probes(baked);
    for (const vec3 p : randomPoints(96, 1000, vec3(-2), vec3(7))) EXPECT_EQ(probes.sample(p).occlusion[3], 1.0f);
}

// Each of an instanced draw's spheres has the light and occlusion of its own place.
TEST(InstancesS15, A1023SpheresEachHaveTheirOwnSample)
{
    const BakedScene baked = probeGrid({9, 7, 8}, rough);
    const ProbeInterpolator probes(baked);
    const std::vector<vec3> places = randomPoints(91, 1023, {-4, -1, 4}, {12, 15, 12});
    const std::vector<ProbeSample> samples = sampleProbes(probes, places);
    ASSERT_EQ(samples.size(), 1023u);
    int distinct = 0;
    for (std::size_t i = 0; i < places.size(); ++i) {
        const ProbeSample own = probes.sample(places[i]);
        EXPECT_EQ(samples[i].occlusion, own.occlusion);
        EXPECT_EQ(samples[i].radiance, own.radiance);
        distinct += i > 0 && samples[i].occlusion != samples[i - 1].occlusion;
    }
    EXPECT_GT(distinct, 1000);
    EXPECT_TRUE(sampleProbes(probes, {}).empty());
}

// Without probes: the sky, whose irradiance (here by brute-force integration) the SH must give. The gradient has a kink
// at the horizon, so L2 is exact to about a percent.
TEST(ProbesS14, WithoutProbesTheSkyLights)
{
    BakedScene baked = emptyScene();
    baked.scene.sky = {{2, 3, 8}, {4, 4, 4}, {0.5f, 0.3f, 0.2f}};
    BakedScene hidden = baked; // a set without a valid probe is none
    hidden.probes.probes = {probeOf({0, 0, 0}, 1000.0f, false)};
    const ProbeSample sample = sampleProbes(hidden, {1, 2, 3});
    EXPECT_EQ(sample.radiance, sampleProbes(baked, {1, 2, 3}).radiance);
    EXPECT_EQ(sample.occlusion, MaskValues());
    const Sky& sky = baked.scene.sky;
    Random random(8);
    for (int n = 0; n < 12; ++n) {
        const vec3 normal = n == 0 ? vec3(0, 1, 0) : n == 1 ? vec3(0, -1, 0) : random.direction();
        glm::dvec3 truth(0.0);
        const int steps = 400;
        for (int i = 0; i < steps; ++i) {
            const float y = -1.0f + 2.0f * (float(i) + 0.5f) / steps;
            const float r = std::sqrt(1.0f - y * y);
            for (int j = 0; j < steps; ++j) {
                const float phi = 2.0f * kPi * (float(j) + 0.5f) / steps;
                const vec3 d(r * std::cos(phi), y, r * std::sin(phi));
                const float cosine = std::max(0.0f, glm::dot(d, normal));
                truth += glm::dvec3(shading::skyRadiance(sky.zenith, sky.horizon, sky.ground, d) * cosine);
            }
        }
        truth *= 4.0 * kPi / (double(steps) * steps);
        vec3 irradiance(0.0f);
        for (int i = 0; i < 9; ++i)
            irradiance += sample.radiance[std::size_t(i)] * shading::shIrradianceWeight(i, normal);
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(irradiance[c], truth[c], 0.02 * truth[c] + 0.02) << "normal " << normal.y;
    }
}

// The coefficients themselves, by quadrature.
TEST(ProbesS14, SkyProjectionIsExact)
{
    const Sky sky{{2, 3, 8}, {4, 4, 4}, {0.5f, 0.3f, 0.2f}};
    const ProbeSample sample = skyProbe(sky);
    for (int k = 0; k < 9; ++k) {
        glm::dvec3 truth(0.0);
        const int steps = 600;
        for (int i = 0; i < steps; ++i) {
            const float y = -1.0f + 2.0f * (float(i) + 0.5f) / steps;
            const float r = std::sqrt(1.0f - y * y);
            for (int j = 0; j < 64; ++j) {
                const float phi = 2.0f * kPi * (float(j) + 0.5f) / 64;
                const vec3 d(r * std::cos(phi), y, r * std::sin(phi));
                truth +=
                    glm::dvec3(shading::skyRadiance(sky.zenith, sky.horizon, sky.ground, d) * shading::shBasis(k, d));
            }
        }
        truth *= 4.0 * kPi / (steps * 64.0);
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(sample.radiance[std::size_t(k)][c], truth[c], 1e-3) << "coefficient " << k;
    }
}

TEST(ProbesS14, NoProbesAndNoSkyIsDark)
{
    const ProbeSample sample = sampleProbes(emptyScene(), {0, 0, 0});
    for (const vec3& c : sample.radiance) EXPECT_EQ(c, vec3(0.0f));
    EXPECT_EQ(sample.occlusion, MaskValues());
}

} // namespace
} // namespace halflight::object_light_test
