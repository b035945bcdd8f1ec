#include "halflight/shading/sh.h"
#include "halflight/shading/sky.h"

#include <array>
#include <gtest/gtest.h>

namespace halflight::shading::sh_test {
namespace {

/// Integral over the sphere by the midpoint rule in y and azimuth: exact in azimuth for low orders, 1e-6 in y. The
/// skies below have their kinks at y = 0, between two slices.
template<typename F> double integrateSphere(F f)
{
    constexpr int kSlices = 2000;
    constexpr int kAzimuths = 32;
    double sum = 0.0;
    for (int i = 0; i < kSlices; ++i) {
        const double y = -1.0 + 2.0 * (i + 0.5) / kSlices;
        const double r = std::sqrt(1.0 - y * y);
        for (int j = 0; j < kAzimuths; ++j) {
            const double phi = 2.0 * double(kPi) * (j + 0.5) / kAzimuths;
            sum += f(vec3(float(r * std::cos(phi)), float(y), float(r * std::sin(phi))));
        }
    }
    return sum * 4.0 * double(kPi) / (double(kSlices) * kAzimuths);
}

template<typename Radiance> std::array<float, 9> project(Radiance radiance)
{
    std::array<float, 9> result{};
    for (int i = 0; i < 9; ++i) {
        result[std::size_t(i)] =
            float(integrateSphere([&](vec3 d) { return double(radiance(d)) * double(shBasis(i, d)); }));
    }
    return result;
}

float irradiance(const std::array<float, 9>& sh, vec3 n)
{
    float sum = 0.0f;
    for (int i = 0; i < 9; ++i) sum += sh[std::size_t(i)] * shIrradianceWeight(i, n);
    return sum;
}

const vec3 kNormals[] = {{0, 1, 0}, {0, -1, 0}, {1, 0, 0}, {0, 0, 1}, {0.6f, 0.8f, 0}, {0.48f, -0.6f, 0.64f}};

TEST(Sh, BasisIsOrthonormal)
{
    for (int i = 0; i < 9; ++i) {
        for (int j = 0; j <= i; ++j) {
            const double product =
                integrateSphere([&](vec3 d) { return double(shBasis(i, d)) * double(shBasis(j, d)); });
            EXPECT_NEAR(product, i == j ? 1.0 : 0.0, 1e-5) << i << " " << j;
        }
    }
}

TEST(Sh, ConstantSkyGivesPiTimesRadiance)
{
    const auto sh = project([](vec3) { return 2.5f; });
    for (const vec3& n : kNormals) EXPECT_NEAR(irradiance(sh, n), 2.5f * kShadingPi, 1e-4f);
}

// Radiance 1 + d.y: irradiance pi + (2 pi / 3) n.y, exactly, because it is in bands 0 and 1.
TEST(Sh, LinearSkyIsExact)
{
    const auto sh = project([](vec3 d) { return 1.0f + d.y; });
    for (const vec3& n : kNormals) EXPECT_NEAR(irradiance(sh, n), kShadingPi + 2.0f * kShadingPi / 3.0f * n.y, 1e-4f);
}

// Radiance d.y^2 = 1/3 + 2/3 P2: irradiance pi / 3 + (pi / 4) (2 / 3) P2(n.y).
TEST(Sh, QuadraticSkyIsExact)
{
    const auto sh = project([](vec3 d) { return d.y * d.y; });
    for (const vec3& n : kNormals) {
        const float p2 = 0.5f * (3.0f * n.y * n.y - 1.0f);
        EXPECT_NEAR(irradiance(sh, n), kShadingPi / 3.0f + kShadingPi / 6.0f * p2, 1e-4f);
    }
}

// Radiance max(d.y, 0): its coefficients are the clamped cosine's own (Ramamoorthi and Hanrahan 2001, eq. 8), and the
// irradiance on an upward surface is 2 pi / 3, of which bands 0 to 2 hold all but 0.8 %.
TEST(Sh, CosineSky)
{
    const auto sh = project([](vec3 d) { return std::max(d.y, 0.0f); });
    for (int i = 0; i < 9; ++i) EXPECT_NEAR(sh[std::size_t(i)], shIrradianceWeight(i, vec3(0, 1, 0)), 1e-4f) << i;
    const float truth = 2.0f * kShadingPi / 3.0f;
    EXPECT_NEAR(irradiance(sh, {0, 1, 0}), truth, 0.01f * truth);
    const float bands =
        kShadingPi / 4.0f + kShadingPi / 3.0f + 5.0f * kShadingPi / 64.0f; // A_l^2 (2 l + 1) / (4 pi) summed
    EXPECT_NEAR(irradiance(sh, {0, 1, 0}), bands, 1e-4f);
}

TEST(Sky, LinearBetweenItsColours)
{
    const vec3 z(1, 2, 3);
    const vec3 h(10, 20, 30);
    const vec3 g(100, 200, 300);
    EXPECT_EQ(skyRadiance(z, h, g, {0, 1, 0}), z);
    EXPECT_EQ(skyRadiance(z, h, g, {1, 0, 0}), h);
    EXPECT_EQ(skyRadiance(z, h, g, {0, -1, 0}), g);
    EXPECT_LT(length(skyRadiance(z, h, g, {std::sqrt(0.75f), 0.5f, 0}) - vec3(5.5f, 11, 16.5f)), 1e-4f);
    EXPECT_LT(length(skyRadiance(z, h, g, {std::sqrt(0.75f), -0.5f, 0}) - vec3(55, 110, 165)), 1e-3f);
}

} // namespace
} // namespace halflight::shading::sh_test
