#include "halflight/shading/sh.h"
#include "halflight/shading/sky.h"
#include "plan_scene.h"

#include <gtest/gtest.h>

namespace halflight {
namespace {

using namespace test;

/// A grid whose probes hold `value(position)` in every coefficient and channel.
template<typename Value> BakedScene grid(ivec3 size, Value value)
{
    BakedScene baked = emptyScene();
    ProbeSet& set = baked.probes;
    set.size = size;
    set.origin = {-2, 1, 5};
    set.spacingMeters = {1.5f, 2.0f, 0.75f};
    for (int z = 0; z < size.z; ++z) {
        for (int y = 0; y < size.y; ++y) {
            for (int x = 0; x < size.x; ++x) {
                Probe probe;
                probe.position = set.origin + set.spacingMeters * vec3(x, y, z);
                for (std::size_t i = 0; i < 9; ++i) probe.radiance[i] = vec3(value(probe.position) + float(i));
                probe.occlusion = vec4(value(probe.position));
                set.probes.push_back(probe);
            }
        }
    }
    return baked;
}

void expectValue(const ProbeSample& sample, float value, float tolerance = 1e-4f)
{
    for (std::size_t i = 0; i < 9; ++i) {
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(sample.radiance[i][c], value + float(i), tolerance);
    }
    for (int c = 0; c < 4; ++c) EXPECT_NEAR(sample.occlusion[c], value, tolerance);
}

TEST(ProbesS14, ConstantAndLinearFieldsAreReproduced)
{
    const auto linear = [](vec3 p) { return 0.5f + 0.1f * p.x - 0.2f * p.y + 0.05f * p.z; };
    const BakedScene constant = grid({4, 3, 5}, [](vec3) { return 0.37f; });
    const BakedScene sloped = grid({4, 3, 5}, linear);
    Random random(4);
    for (int n = 0; n < 300; ++n) {
        const vec3 inside = random.in({-2, 1, 5}, {2.5f, 5, 8});
        expectValue(sampleProbes(constant, inside), 0.37f);
        expectValue(sampleProbes(sloped, inside), linear(inside));
        const vec3 anywhere = random.in(vec3(-30), vec3(30));
        expectValue(sampleProbes(constant, anywhere), 0.37f);
        // Outside: the value at the grid's nearest point.
        expectValue(sampleProbes(sloped, anywhere), linear(glm::clamp(anywhere, vec3(-2, 1, 5), vec3(2.5f, 5, 8))));
    }
}

TEST(ProbesS14, FlatGridsWork)
{
    const auto linear = [](vec3 p) { return 0.5f + 0.1f * p.x + 0.05f * p.z; };
    expectValue(sampleProbes(grid({4, 1, 5}, linear), {0.3f, 99, 6.1f}), linear({0.3f, 1, 6.1f}));
    expectValue(sampleProbes(grid({1, 1, 1}, linear), {9, 9, 9}), linear({-2, 1, 5}));
}

TEST(ProbesS14, InvalidProbesAreLeftOut)
{
    // A field with a poisoned probe: constant elsewhere, so dropping and renormalizing gives the constant.
    BakedScene baked = grid({4, 3, 5}, [](vec3) { return 0.25f; });
    const std::size_t poisoned = (2 * 3 + 1) * 4 + 1;
    baked.probes.probes[poisoned].valid = false;
    baked.probes.probes[poisoned].occlusion = vec4(1000.0f);
    baked.probes.probes[poisoned].radiance.fill(vec3(1e6f));
    Random random(6);
    const vec3 at = baked.probes.probes[poisoned].position;
    expectValue(sampleProbes(baked, at), 0.25f); // on the invalid probe itself
    for (int n = 0; n < 200; ++n) expectValue(sampleProbes(baked, at + random.in(vec3(-1.4f), vec3(1.4f))), 0.25f);
}

TEST(ProbesS14, WeightsOfValidProbesKeepTheirProportion)
{
    BakedScene baked = grid({2, 1, 1}, [](vec3 p) { return p.x < -1 ? 0.2f : 0.8f; });
    expectValue(sampleProbes(baked, {-2 + 1.5f * 0.25f, 1, 5}), 0.75f * 0.2f + 0.25f * 0.8f);
    baked.probes.probes[1].valid = false;
    expectValue(sampleProbes(baked, {-2 + 1.5f * 0.25f, 1, 5}), 0.2f);
}

TEST(ProbesS14, AllEightInvalidTakesTheNearestValid)
{
    BakedScene baked = grid({5, 5, 5}, [](vec3 p) { return p.x; });
    for (Probe& probe : baked.probes.probes) probe.valid = false;
    baked.probes.probes.front().valid = true;
    baked.probes.probes.back().valid = true;
    expectValue(sampleProbes(baked, {-1.9f, 3, 6.2f}), -2.0f);
    expectValue(sampleProbes(baked, {3.9f, 7, 7.0f}), 4.0f);
}

TEST(ProbesS14, FreeListUsesTheNearestFour)
{
    BakedScene baked = emptyScene();
    const auto add = [&](vec3 p, float value, bool valid = true) {
        Probe probe;
        probe.position = p;
        probe.occlusion = vec4(value);
        for (std::size_t i = 0; i < 9; ++i) probe.radiance[i] = vec3(value + float(i));
        probe.valid = valid;
        baked.probes.probes.push_back(probe);
    };
    add({1, 0, 0}, 0.1f);
    add({0, 2, 0}, 0.9f);
    add({0, 0.1f, 0}, 555.0f, false); // inside geometry
    add({50, 0, 0}, 0.5f);
    add({0, 0, 2}, 0.3f);
    add({-1, 0, 0}, 0.7f);
    // Weights 1 / d^2 of the four nearest valid: 1, 1/4, 1/4, 1.
    expectValue(sampleProbes(baked, {0, 0, 0}), (0.1f + 0.7f + 0.25f * 0.9f + 0.25f * 0.3f) / 2.5f);
    expectValue(sampleProbes(baked, {1, 0, 0}), 0.1f);
}

// Without probes: the sky, whose irradiance (here by brute-force integration) the SH must give. The gradient has a kink
// at the horizon, so L2 is exact to about a percent.
TEST(ProbesS14, WithoutProbesTheSkyLights)
{
    BakedScene baked = emptyScene();
    baked.scene.sky = {{2, 3, 8}, {4, 4, 4}, {0.5f, 0.3f, 0.2f}};
    const ProbeSample sample = sampleProbes(baked, {1, 2, 3});
    EXPECT_EQ(sample.occlusion, vec4(1.0f));
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
    EXPECT_EQ(sample.occlusion, vec4(1.0f));
}

} // namespace
} // namespace halflight
