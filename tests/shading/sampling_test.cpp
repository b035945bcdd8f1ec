#include "halflight/shading/sampling.h"
#include "halflight/shading/sobol.h"

#include <gtest/gtest.h>
#include <vector>

namespace halflight::shading::sampling_test {
namespace {

/// Mean of f over a fine regular grid of the unit square.
template<typename F> double mean(F f, int side = 1000)
{
    double sum = 0.0;
    for (int i = 0; i < side; ++i) {
        for (int j = 0; j < side; ++j)
            sum += double(f(vec2((float(i) + 0.5f) / float(side), (float(j) + 0.5f) / float(side))));
    }
    return sum / (double(side) * side);
}

/// Area (or solid angle) of the image of a small square about u, by central differences: 1 / pdf.
template<typename Warp> double stretch(Warp warp, vec2 u)
{
    const float e = 1e-3f;
    const vec3 a = (vec3(warp(u + vec2(e, 0))) - vec3(warp(u - vec2(e, 0)))) / (2.0f * e);
    const vec3 b = (vec3(warp(u + vec2(0, e))) - vec3(warp(u - vec2(0, e)))) / (2.0f * e);
    return double(length(cross(a, b)));
}

// Points away from the seams of the maps.
const vec2 kPoints[] = {{0.2f, 0.3f}, {0.35f, 0.15f}, {0.8f, 0.7f}, {0.61f, 0.9f}, {0.1f, 0.77f}, {0.93f, 0.4f}};

TEST(Sampling, DiscIsUniform)
{
    const auto warp = [](vec2 u) { return vec3(sampleDisc(u), 0.0f); };
    for (const vec2 u : kPoints) EXPECT_NEAR(stretch(warp, u), double(kPi), 0.01) << "pdf 1 / pi";
    EXPECT_NEAR(mean([](vec2 u) { return dot(sampleDisc(u), sampleDisc(u)); }), 0.5, 1e-3);
    EXPECT_NEAR(mean([](vec2 u) { return sampleDisc(u).x; }), 0.0, 1e-5);
    EXPECT_NEAR(mean([](vec2 u) { return square(sampleDisc(u).y); }), 0.25, 1e-3);
    for (const vec2 corner : {vec2(0, 0), vec2(1, 0), vec2(0, 1), vec2(1, 1)})
        EXPECT_LE(length(sampleDisc(corner)), 1.0001f);
    EXPECT_EQ(sampleDisc(vec2(0.5f)), vec2(0.0f));
}

TEST(Sampling, CosineHemisphere)
{
    for (const vec2 u : kPoints) {
        EXPECT_NEAR(stretch(sampleCosineHemisphere, u) * double(sampleCosineHemisphere(u).z) / double(kPi), 1.0, 0.01)
            << "pdf cos / pi";
        EXPECT_NEAR(length(sampleCosineHemisphere(u)), 1.0f, 1e-5f);
    }
    EXPECT_NEAR(mean([](vec2 u) { return sampleCosineHemisphere(u).z; }), 2.0 / 3.0, 1e-3);
    EXPECT_NEAR(mean([](vec2 u) { return square(sampleCosineHemisphere(u).z); }), 0.5, 1e-3);
    EXPECT_NEAR(mean([](vec2 u) { return square(sampleCosineHemisphere(u).x); }), 0.25, 1e-3);
    EXPECT_NEAR(mean([](vec2 u) { return sampleCosineHemisphere(u).y; }), 0.0, 1e-4);
}

TEST(Sampling, Sphere)
{
    for (const vec2 u : kPoints) {
        EXPECT_NEAR(stretch(sampleSphere, u), 4.0 * double(kPi), 0.05) << "pdf 1 / (4 pi)";
        EXPECT_NEAR(length(sampleSphere(u)), 1.0f, 1e-5f);
    }
    for (int axis = 0; axis < 3; ++axis) {
        EXPECT_NEAR(mean([&](vec2 u) { return sampleSphere(u)[axis]; }), 0.0, 1e-4);
        EXPECT_NEAR(mean([&](vec2 u) { return square(sampleSphere(u)[axis]); }), 1.0 / 3.0, 1e-3);
    }
}

TEST(Sampling, TriangleIsUniform)
{
    const auto warp = [](vec2 u) { return vec3(sampleTriangle(u), 0.0f); };
    for (const vec2 u : kPoints) EXPECT_NEAR(stretch(warp, u), 0.5, 0.01) << "pdf 1 / area";
    // Means 1/3 and second moments 1/6, 1/12 of barycentric coordinates.
    EXPECT_NEAR(mean([](vec2 u) { return sampleTriangle(u).x; }), 1.0 / 3.0, 1e-3);
    EXPECT_NEAR(mean([](vec2 u) { return sampleTriangle(u).y; }), 1.0 / 3.0, 1e-3);
    EXPECT_NEAR(mean([](vec2 u) { return square(sampleTriangle(u).x); }), 1.0 / 6.0, 1e-3);
    EXPECT_NEAR(mean([](vec2 u) { return sampleTriangle(u).x * sampleTriangle(u).y; }), 1.0 / 12.0, 1e-3);
    mean(
        [](vec2 u) {
            const vec2 b = sampleTriangle(u);
            EXPECT_TRUE(b.x >= 0.0f && b.y >= 0.0f && b.x + b.y <= 1.0f + 1e-6f);
            return 0.0f;
        },
        100);
}

TEST(Sampling, BasisIsOrthonormalEverywhere)
{
    std::vector<vec3> normals = {{0, 0, 1},  {0, 0, -1},    {1, 0, 0},
                                 {0, -1, 0}, {0, 1, -0.0f}, normalize(vec3(1e-4f, -1e-4f, -1))};
    for (int i = 0; i < 400; ++i)
        normals.push_back(sampleSphere({(float(i % 20) + 0.5f) / 20, (float(i / 20) + 0.5f) / 20}));
    for (const vec3& n : normals) {
        vec3 t;
        vec3 b;
        orthonormalBasis(n, t, b);
        EXPECT_NEAR(length(t), 1.0f, 1e-5f);
        EXPECT_NEAR(length(b), 1.0f, 1e-5f);
        EXPECT_NEAR(dot(t, b), 0.0f, 1e-5f);
        EXPECT_LT(length(cross(t, b) - n), 1e-5f) << "right-handed";
    }
}

TEST(Sampling, PowerHeuristicWeightsSumToOne)
{
    for (const float a : {0.0f, 0.1f, 1.0f, 30.0f}) {
        for (const float b : {0.2f, 1.0f, 7.0f}) {
            EXPECT_NEAR(powerHeuristic(a, b) + powerHeuristic(b, a), 1.0f, 1e-6f);
            EXPECT_NEAR(powerHeuristic(a, b), a * a / (a * a + b * b), 1e-6f);
        }
    }
    EXPECT_EQ(powerHeuristic(0.0f, 0.0f), 0.0f);
}

/// The generator matrix of the second dimension, column by column: each is the one before and its half (Sobol' 1967).
TEST(Sampling, SobolsSecondDimensionIsItsMatrixTimesTheIndex)
{
    uint index = 1;
    for (int i = 0; i < 10000; ++i, index = hashPcg(index)) {
        uint expected = 0;
        uint column = 0x80000000u;
        for (uint bit = 0; bit < 32; ++bit, column ^= column >> 1)
            if (((index >> bit) & 1u) != 0) expected ^= column;
        ASSERT_EQ(reversedBits(sobolSecondReversed(index)), expected) << index;
    }
}

/// Every interval of 2^-k by 2^(k-10) holds one of 1,024 scrambled points, whatever the seed.
TEST(Sampling, ScrambledSobolPointsAreStratified)
{
    constexpr uint kBits = 10;
    for (const uint seed : {1u, 77u, 0xdeadbeefu}) {
        for (uint k = 0; k <= kBits; ++k) {
            std::vector<int> found(std::size_t(1) << kBits);
            for (uint i = 0; i < found.size(); ++i) {
                const uvec2 p = scrambledSobol(i, seed);
                const uint column = k == 0 ? 0u : p.x >> (32u - k);
                const uint row = k == kBits ? 0u : p.y >> (32u - (kBits - k));
                ++found[(column << (kBits - k)) | row];
            }
            for (const int count : found) ASSERT_EQ(count, 1) << "seed " << seed << ", k " << k;
        }
    }
}

} // namespace
} // namespace halflight::shading::sampling_test
