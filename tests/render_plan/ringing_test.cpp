#include "halflight/shading/sh.h"
#include "probe_sets.h"

#include <gtest/gtest.h>

#include <cmath>

namespace halflight::ringing_test {
namespace {

using namespace test;

/// Light from one direction only.
SphericalHarmonicsL2 deltaLight(vec3 direction, vec3 color)
{
    SphericalHarmonicsL2 sh{};
    for (int i = 0; i < 9; ++i) sh[std::size_t(i)] = color * shading::shBasis(i, direction);
    return sh;
}

SphericalHarmonicsL2 operator+(SphericalHarmonicsL2 a, const SphericalHarmonicsL2& b)
{
    for (std::size_t i = 0; i < 9; ++i) a[i] += b[i];
    return a;
}

/// Least irradiance of a channel over a fine net of normals (Fibonacci lattice), in doubles.
double leastIrradiance(const SphericalHarmonicsL2& sh, int channel)
{
    double least = 1.0e30;
    const int count = 40000;
    for (int k = 0; k < count; ++k) {
        const double z = 1.0 - 2.0 * (k + 0.5) / count;
        const double phi = k * 2.399963229728653;
        const double r = std::sqrt(1.0 - z * z);
        const vec3 n(r * std::cos(phi), r * std::sin(phi), z);
        double sum = 0.0;
        for (int i = 0; i < 9; ++i)
            sum += double(sh[std::size_t(i)][channel]) * double(shading::shIrradianceWeight(i, n));
        least = std::min(least, sum);
    }
    return least;
}

double meanIrradiance(const SphericalHarmonicsL2& sh, int channel)
{
    return double(sh[0][channel]) * 0.886226925;
}

TEST(RingingS14, DeltaLightHasNoNegativeIrradianceAndKeepsItsMean)
{
    Random random(1);
    for (int n = 0; n < 20; ++n) {
        const vec3 direction = n == 0 ? vec3(0, 1, 0) : n == 1 ? vec3(0, 0, -1) : random.direction();
        const SphericalHarmonicsL2 sh = deltaLight(direction, {3000, 2, 0.01f});
        const SphericalHarmonicsL2 windowed = withoutRinging(sh);
        EXPECT_EQ(windowed[0], sh[0]);
        for (int c = 0; c < 3; ++c) {
            const double mean = meanIrradiance(sh, c);
            EXPECT_LT(leastIrradiance(sh, c), -0.1 * mean) << "the test needs ringing";
            // Not negative, and no more windowed than that takes: the least value is about 0. L2's share for a delta
            // light, by hand: 1/4 over the largest dip of 1/4 + cos / 2 + 5/32 (3 cos^2 - 1) below the mean.
            EXPECT_GE(leastIrradiance(windowed, c), -1.0e-6 * mean);
            EXPECT_LT(leastIrradiance(windowed, c), 1.0e-3 * mean);
            const double window =
                double(glm::dot(windowed[1], vec3(1)) + glm::dot(windowed[2], vec3(1)) +
                       glm::dot(windowed[3], vec3(1))) /
                double(glm::dot(sh[1], vec3(1)) + glm::dot(sh[2], vec3(1)) + glm::dot(sh[3], vec3(1)));
            const double cosine = -0.5 / (6.0 * 5.0 / 32.0);
            const double dip = 0.5 * cosine + 5.0 / 32.0 * (3.0 * cosine * cosine - 1.0);
            EXPECT_NEAR(window, -0.25 / dip, 1.0e-4);
        }
    }
}

TEST(RingingS14, AnyLightIsMadeNonNegativeAndNoMoreThanNeeded)
{
    Random random(2);
    int rang = 0;
    for (int n = 0; n < 60; ++n) {
        SphericalHarmonicsL2 sh{};
        for (std::size_t i = 0; i < 9; ++i) sh[i] = random.in(vec3(-1), vec3(1));
        sh[0] = random.in(vec3(0), vec3(4));
        const SphericalHarmonicsL2 windowed = withoutRinging(sh);
        for (int c = 0; c < 3; ++c) {
            const double before = leastIrradiance(sh, c);
            const double after = leastIrradiance(windowed, c);
            const double mean = meanIrradiance(sh, c);
            EXPECT_EQ(windowed[0][c], sh[0][c]);
            EXPECT_GE(after, -1.0e-5 * mean);
            if (before < -1.0e-4) {
                ++rang;
                EXPECT_LT(after, 2.0e-3 * mean + 1.0e-4);
            } else if (before > 1.0e-4) {
                for (std::size_t i = 0; i < 9; ++i) EXPECT_EQ(windowed[i][c], sh[i][c]); // untouched
            }
            // One factor for all of bands 1 and 2.
            const float factor = windowed[1][c] / sh[1][c];
            EXPECT_GE(factor, 0.0f);
            EXPECT_LE(factor, 1.0f);
            for (std::size_t i = 2; i < 9; ++i) EXPECT_NEAR(windowed[i][c], factor * sh[i][c], 1.0e-5f);
        }
    }
    EXPECT_GT(rang, 50);
}

// Where the quadratic's minimum is degenerate: a whole circle of minima, no band 1, no band 2, nothing.
TEST(RingingS14, SpecialCases)
{
    for (std::size_t only = 1; only < 9; ++only) {
        for (const float value : {50.0f, -50.0f, 0.01f}) {
            SphericalHarmonicsL2 sh{};
            sh[0] = vec3(1);
            sh[only] = vec3(value);
            const SphericalHarmonicsL2 windowed = withoutRinging(sh);
            EXPECT_EQ(windowed[0], vec3(1));
            EXPECT_GE(leastIrradiance(windowed, 0), -1.0e-5) << only << " " << value;
            if (std::abs(value) > 1.0f) EXPECT_LT(leastIrradiance(windowed, 0), 2.0e-3) << only << " " << value;
            if (std::abs(value) < 1.0f) EXPECT_EQ(windowed, sh);
        }
    }
    // Band 1 along an axis on which band 2 does not press: the hard case of trust regions.
    SphericalHarmonicsL2 hard{};
    hard[0] = vec3(1);
    hard[2] = vec3(0.5f);
    hard[8] = vec3(40);
    EXPECT_GE(leastIrradiance(withoutRinging(hard), 0), -1.0e-5);
    EXPECT_LT(leastIrradiance(withoutRinging(hard), 0), 2.0e-3);
    EXPECT_EQ(withoutRinging({}), SphericalHarmonicsL2{});
    SphericalHarmonicsL2 meanless{};
    meanless[3] = vec3(1);
    EXPECT_EQ(withoutRinging(meanless), SphericalHarmonicsL2{});
    SphericalHarmonicsL2 negative{};
    negative[0] = vec3(-1); // no light, but no reason for NaN either
    EXPECT_EQ(withoutRinging(negative), negative);
}

TEST(RingingS14, ContinuousInTheLight)
{
    const vec3 a = glm::normalize(vec3(1, 2, 3));
    SphericalHarmonicsL2 previous{};
    float largest = 0.0f;
    for (int i = 0; i <= 2000; ++i) {
        // A second light comes up until nothing rings.
        const SphericalHarmonicsL2 now =
            withoutRinging(deltaLight(a, vec3(1)) + deltaLight(-a, vec3(float(i) / 2000.0f)));
        if (i > 0) {
            for (std::size_t k = 0; k < 9; ++k) largest = std::max(largest, std::abs(now[k].x - previous[k].x));
        }
        previous = now;
    }
    EXPECT_LT(largest, 3.0e-3f);
    EXPECT_EQ(previous, deltaLight(a, vec3(1)) + deltaLight(-a, vec3(1)));
}

TEST(RingingS14, SamplesAreWindowedUnlessToldNot)
{
    BakedScene baked = probeGrid({2, 2, 2}, [](vec3) { return 0.0f; });
    const SphericalHarmonicsL2 sh = deltaLight({0, 1, 0}, vec3(5));
    for (Probe& probe : baked.probes.probes) probe.radiance = sh;
    const vec3 at = baked.probes.probes[0].position;
    EXPECT_LT(leastIrradiance(ProbeInterpolator(baked, {.withoutRinging = false}).sample(at).radiance, 0), -0.1);
    EXPECT_GE(leastIrradiance(ProbeInterpolator(baked).sample(at).radiance, 0), -1.0e-5);
    EXPECT_GE(leastIrradiance(sampleProbes(baked, at).radiance, 0), -1.0e-5);
}

} // namespace
} // namespace halflight::ringing_test
