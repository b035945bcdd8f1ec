// Sampling of glTF's BRDF: densities integrate to 1 and are those of the samples, estimates have the BRDF's albedo.
#include "halflight/shading/brdf_sampling.h"

#include <gtest/gtest.h>

#include <vector>

namespace halflight::shading::brdf_sampling_test {
namespace {

const vec3 kNormal(0, 0, 1);

vec3 viewAt(float cosine)
{
    return {std::sqrt(1.0f - cosine * cosine), 0.0f, cosine};
}

/// Calls f(direction, solid angle) for a fine grid over the sphere, in the cosine to `axis` and the angle about it.
/// Cells are narrow near the axis: the k-th ends at angle pi (k / n)^3.
template<typename F> void overSphere(vec3 axis, int rings, int sectors, F f)
{
    vec3 t;
    vec3 b;
    orthonormalBasis(axis, t, b);
    double above = 1.0;
    for (int i = 0; i < rings; ++i) {
        const double end = double(i + 1) / rings;
        const double below = std::cos(double(kPi) * end * end * end);
        const double middle = double(i + 0.5) / rings;
        const double angle = double(kPi) * middle * middle * middle;
        for (int j = 0; j < sectors; ++j) {
            const double phi = 2.0 * double(kPi) * (j + 0.5) / sectors;
            const vec3 direction = float(std::sin(angle) * std::cos(phi)) * t +
                                   float(std::sin(angle) * std::sin(phi)) * b + float(std::cos(angle)) * axis;
            f(direction, (above - below) * 2.0 * double(kPi) / sectors);
        }
        above = below;
    }
}

/// Mean of f(uLobe, u) over a regular grid, both lobes in proportion to their share.
template<typename F> void overSamples(int side, float share, F f)
{
    for (int i = 0; i < side; ++i) {
        for (int j = 0; j < side; ++j) {
            const vec2 u((float(i) + 0.5f) / float(side), (float(j) + 0.5f) / float(side));
            if (share > 0.0f) f(0.0f, u, double(share) / (double(side) * side));
            if (share < 1.0f) f(1.0f, u, (1.0 - double(share)) / (double(side) * side));
        }
    }
}

struct Case {
    float roughness;
    float cosine;
    float share;
};
std::vector<Case> cases()
{
    std::vector<Case> all;
    for (const float roughness : {0.1f, 0.4f, 1.0f})
        for (const float cosine : {0.05f, 0.3f, 0.7f, 1.0f})
            for (const float share : {0.0f, 0.4f, 1.0f}) all.push_back({roughness, cosine, share});
    return all;
}

// Over the whole sphere, directions below the surface included, which the specular lobe has.
TEST(BrdfSampling, DensityIntegratesToOne)
{
    for (const Case& c : cases()) {
        const vec3 v = viewAt(c.cosine);
        double sum = 0.0;
        overSphere(reflect(-v, kNormal), 400, 400, [&](vec3 l, double solidAngle) {
            sum += double(brdfPdf(kNormal, v, l, ggxAlphaOf(c.roughness), c.share)) * solidAngle;
        });
        EXPECT_NEAR(sum, 1.0, 0.01) << c.roughness << ' ' << c.cosine << ' ' << c.share;
    }
}

// Shares of samples by cell of the sphere, against the density integrated over the cell.
TEST(BrdfSampling, SamplesHaveTheirDensity)
{
    constexpr int kRings = 8;
    constexpr int kSectors = 8;
    const auto cellOf = [](vec3 d) {
        const int ring = std::min(int((1.0f - d.z) * 0.5f * kRings), kRings - 1);
        const int sector = int((std::atan2(d.y, d.x) / (2.0f * kPi) + 0.5f) * kSectors);
        return std::size_t(ring * kSectors + std::min(sector, kSectors - 1));
    };
    for (const Case& c : cases()) {
        const vec3 v = viewAt(c.cosine);
        const float alpha = ggxAlphaOf(c.roughness);
        std::vector<double> expected(kRings * kSectors, 0.0);
        overSphere(reflect(-v, kNormal), 400, 400, [&](vec3 l, double solidAngle) {
            expected[cellOf(l)] += double(brdfPdf(kNormal, v, l, alpha, c.share)) * solidAngle;
        });
        std::vector<double> found(kRings * kSectors, 0.0);
        overSamples(400, c.share, [&](float uLobe, vec2 u, double weight) {
            found[cellOf(sampleBrdf(kNormal, v, alpha, c.share, uLobe, u))] += weight;
        });
        for (std::size_t i = 0; i < expected.size(); ++i)
            EXPECT_NEAR(found[i], expected[i], 0.006) << c.roughness << ' ' << c.cosine << ' ' << c.share << ' ' << i;
    }
}

// The estimate of uniform light is the albedo that brute force finds, for metals and dielectrics; never brighter than 1
// for metals. Weights have a limit, so no sample is a firefly.
TEST(BrdfSampling, EstimatesTheAlbedo)
{
    for (const float metallic : {0.0f, 0.5f, 1.0f}) {
        for (const float roughness : {0.1f, 0.3f, 0.6f, 1.0f}) {
            for (const float cosine : {0.1f, 0.5f, 0.95f}) {
                const vec3 v = viewAt(cosine);
                const float alpha = ggxAlphaOf(roughness);
                const float share = specularSamplingShare(vec3(0.9f), metallic, roughness, 1.0f, cosine);
                double truth = 0.0;
                overSphere(reflect(-v, kNormal), 400, 400, [&](vec3 l, double solidAngle) {
                    const vec3 f = reflectLight(vec3(0.9f), metallic, roughness, 1.0f, kNormal, v, l, vec3(1.0f));
                    truth += double(f.x) * solidAngle;
                });
                double found = 0.0;
                double most = 0.0;
                overSamples(256, share, [&](float uLobe, vec2 u, double weight) {
                    const vec3 l = sampleBrdf(kNormal, v, alpha, share, uLobe, u);
                    const vec3 f = reflectLight(vec3(0.9f), metallic, roughness, 1.0f, kNormal, v, l, vec3(1.0f));
                    const double value = f.x > 0.0f ? double(f.x / brdfPdf(kNormal, v, l, alpha, share)) : 0.0;
                    found += value * weight;
                    most = std::max(most, value);
                });
                EXPECT_NEAR(found, truth, 0.006 * truth) << metallic << ' ' << roughness << ' ' << cosine;
                if (metallic == 1.0f) EXPECT_LE(found, 1.0);
                EXPECT_LT(most, metallic == 1.0f ? 1.0001 : 3.2) << metallic << ' ' << roughness << ' ' << cosine;
            }
        }
    }
}

// The smoothest surface is nearly a mirror: samples lie about the mirrored view.
TEST(BrdfSampling, MirrorLimit)
{
    for (const float cosine : {0.1f, 0.5f, 0.95f}) {
        const vec3 v = viewAt(cosine);
        const vec3 mirror(-v.x, 0.0f, v.z);
        int near = 0;
        overSamples(64, 1.0f, [&](float, vec2 u, double) {
            near += dot(sampleBrdf(kNormal, v, ggxAlphaOf(0.0f), 1.0f, 0.0f, u), mirror) > std::cos(0.02f) ? 1 : 0;
        });
        EXPECT_GE(near, 64 * 64 * 95 / 100) << cosine;
    }
}

// A view behind the shading normal (of a normal map) has densities too: those of the mirrored view.
TEST(BrdfSampling, ViewsBelowTheSurface)
{
    const vec3 v = normalize(vec3(0.9f, 0.1f, -0.2f));
    double sum = 0.0;
    overSphere(normalize(vec3(-0.9f, -0.1f, 0.2f)), 400, 400, [&](vec3 l, double solidAngle) {
        sum += double(brdfPdf(kNormal, v, l, ggxAlphaOf(0.4f), 0.7f)) * solidAngle;
    });
    EXPECT_NEAR(sum, 1.0, 0.01);
    overSamples(64, 0.7f, [&](float uLobe, vec2 u, double) {
        const vec3 l = sampleBrdf(kNormal, v, ggxAlphaOf(0.4f), 0.7f, uLobe, u);
        EXPECT_NEAR(length(l), 1.0f, 1e-5f);
        EXPECT_GT(brdfPdf(kNormal, v, l, ggxAlphaOf(0.4f), 0.7f), 0.0f);
    });
}

} // namespace
} // namespace halflight::shading::brdf_sampling_test
