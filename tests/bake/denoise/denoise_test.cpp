// The denoiser on light whose truth is given (spec S6).

#include "bake/denoise/denoise.h"
#include "bake/geometry/flatten.h"
#include "bake/test_scene.h"
#include "bake/texels/rasterize.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace halflight::test::denoise_test {
namespace {

constexpr int kPage = 64;

/// One chart on a page: a rectangle between two corners, in texels.
struct OneChart {
    explicit OneChart(vec2 low, vec2 high)
    {
        Scene scene;
        addRectangle(scene, {}, addMaterial(scene, vec3(0.5f)), kPage, {low, high});
        geometry = flattenGeometry(scene, kPage, GeometryFilter::Static);
        map = rasterizeTexels(geometry, kPage, 1);
    }
    /// Denoises what estimateOf(texel) tells of each texel.
    template<typename EstimateOf>
    [[nodiscard]] std::vector<IrradianceEstimate> denoised(const EstimateOf& estimateOf, bool directions = false) const
    {
        std::vector<IrradianceEstimate> estimates;
        for (const Texel& texel : map.texels) estimates.push_back(estimateOf(texel));
        denoise(geometry, map, {}, estimates, directions);
        return estimates;
    }
    void expectEven(const std::vector<IrradianceEstimate>& estimates) const ///< light of 1 everywhere
    {
        for (std::size_t i = 0; i < estimates.size(); ++i)
            EXPECT_NEAR(estimates[i].irradiance.x, 1.0f, 0.02f) << map.texels[i].x << ", " << map.texels[i].y;
    }
    [[nodiscard]] std::size_t at(int x, int y) const ///< number of a texel
    {
        const auto isThere = [&](const Texel& t) { return t.x == x && t.y == y; };
        return std::size_t(std::find_if(map.texels.begin(), map.texels.end(), isThere) - map.texels.begin());
    }
    BakeGeometry geometry;
    TexelMap map;
};

/// A page of noisy estimates of light that is known, before and after denoising.
struct NoisyPage {
    template<typename Truth> NoisyPage(const Truth& truth, float sigma, float variance)
        : NoisyPage(
              truth, [](const Texel&) { return 0.0f; }, sigma, variance)
    {}
    /// `direct`: light of baked lights beside it, without noise.
    template<typename Truth, typename Direct>
    NoisyPage(const Truth& truth, const Direct& direct, float sigma, float variance)
    {
        const auto [geometry, map] = OneChart(vec2(0), vec2(64));
        std::mt19937 random(9);
        std::normal_distribution<float> noise(0.0f, sigma);
        estimates.resize(map.texels.size());
        for (std::size_t i = 0; i < estimates.size(); ++i) {
            estimates[i].direct = vec3(direct(map.texels[i]));
            expected.push_back(truth(map.texels[i]) + estimates[i].direct.x);
            estimates[i].irradiance = vec3(expected[i] + noise(random));
            estimates[i].varianceOfMean = variance;
            estimates[i].samples = 64;
        }
        before = squares();
        denoise(geometry, map, {}, estimates);
        after = squares();
    }
    [[nodiscard]] double squares() const
    {
        double sum = 0.0;
        for (std::size_t i = 0; i < estimates.size(); ++i)
            sum += std::pow(estimates[i].irradiance.x - expected[i], 2.0);
        return sum;
    }
    std::vector<IrradianceEstimate> estimates;
    std::vector<float> expected;
    double before = 0.0; ///< squared errors, summed
    double after = 0.0;
};

/// Noise goes, edges stay: a step in light survives the denoiser while noise around it shrinks. One texel in a thousand
/// may keep noise of four standard deviations.
TEST(DenoiseS6, SmoothsNoiseAndKeepsEdges)
{
    const NoisyPage page([](const Texel& t) { return t.x < 32 ? 1.0f : 3.0f; }, 0.1f, 0.01f);
    EXPECT_LT(page.after, page.before / 20.0);
    std::size_t noisy = 0;
    for (std::size_t i = 0; i < page.estimates.size(); ++i) {
        const float error = std::abs(page.estimates[i].irradiance.x - page.expected[i]);
        EXPECT_LT(error, 0.5f);
        noisy += error > 0.2f ? 1 : 0;
    }
    EXPECT_LE(noisy, page.estimates.size() / 1000);
}

/// Even light comes out even: no blotches of the size of the first levels' kernels stay.
TEST(DenoiseS6, LeavesNoBlotchesOnEvenLight)
{
    const NoisyPage page([](const Texel&) { return 1.0f; }, 0.1f, 0.01f);
    EXPECT_LT(std::sqrt(page.after / double(page.estimates.size())), 0.01);
}

/// Light that falls off across a wall is smoothed across its slope too, not along lines of equal light alone (which
/// leaves 0.048; without slopes at the chart's rim, 0.031).
TEST(DenoiseS6, SlopesAreSmoothedAcross)
{
    const auto slope = [](const Texel& t) { return 1.0f + 0.04f * float(t.x) + 0.02f * float(t.y); };
    const NoisyPage page(slope, 0.1f, 0.01f);
    EXPECT_LT(std::sqrt(page.after / double(page.estimates.size())), 0.024);
}

/// Light of a lamp close to a wall: steep, and curved everywhere, so that slopes alone leave 0.42 of the noise.
TEST(DenoiseS6, LampsOnWallsAreSmooth)
{
    const auto lamp = [](const Texel& t) {
        const vec2 d(float(t.x) - 30.3f, float(t.y) - 33.8f);
        return 1.0f + 10.0f * std::pow(1.0f + glm::dot(d, d) / 100.0f, -1.5f);
    };
    const NoisyPage page(lamp, 0.2f, 0.04f);
    EXPECT_LT(std::sqrt(page.after / page.before), 0.25);
}

/// The top of a peak of light that covers few texels, and whose blocks agree, is no firefly.
TEST(DenoiseS6, PeaksAreNoFireflies)
{
    const OneChart chart(vec2(4), vec2(60));
    const auto lightAt = [](const Texel& t) {
        const vec2 d(float(t.x) - 30.4f, float(t.y) - 30.3f);
        return 1.0f + 30.0f * std::pow(1.0f + glm::dot(d, d), -1.5f);
    };
    const auto estimates = chart.denoised([&](const Texel& t) {
        IrradianceEstimate e;
        e.irradiance = vec3(lightAt(t));
        e.varianceOfMean = 0.0049f * lightAt(t) * lightAt(t); // 7 %
        e.samples = 200;
        return e;
    });
    for (const std::size_t i : {chart.at(30, 30), chart.at(31, 30), chart.at(30, 31)})
        EXPECT_NEAR(estimates[i].irradiance.x, lightAt(chart.map.texels[i]), 0.2f * lightAt(chart.map.texels[i]));
}

/// Single sunlit texels among unlit ones are no outliers, and the noise of other light beside them goes.
TEST(DenoiseS6, SunlightIsNoNoise)
{
    const auto sun = [](const Texel& t) { return t.x % 5 == 0 && t.y % 3 == 0 ? 0.4f : 0.0f; };
    const NoisyPage page([](const Texel&) { return 1.0f; }, sun, 0.1f, 0.01f);
    EXPECT_LT(page.after, page.before / 50.0);
    for (std::size_t i = 0; i < page.estimates.size(); ++i)
        EXPECT_NEAR(page.estimates[i].irradiance.x, page.expected[i], 0.2f);
}

/// A texel at the rim of a surface that is brighter than all others, and whose blocks agree, stays; one whose blocks do
/// not agree does not.
TEST(DenoiseS6, BrightRimsAreNoOutliers)
{
    const OneChart chart(vec2(4.0f, 4.7f), vec2(60));
    for (const bool agree : {true, false}) {
        const auto estimates = chart.denoised([&](const Texel& t) {
            const bool bright = t.y == 4 && t.x == 30;
            IrradianceEstimate e;
            e.irradiance = vec3(bright ? 2.0f : 1.0f);
            e.varianceOfMean = bright && !agree ? 0.9f : 0.0004f;
            e.samples = 64;
            return e;
        });
        EXPECT_NEAR(estimates[chart.at(30, 4)].irradiance.x, agree ? 2.0f : 1.0f, 0.1f);
    }
}

/// Texels that differ from all around though their blocks agree: some side by side, from (30, 30) on.
struct OddTexels {
    int width;
    int height;
    float light; ///< all others have 1
    uint32_t samples;
    float expected;

    [[nodiscard]] IrradianceEstimate estimateOf(const Texel& t) const
    {
        const bool odd = t.x >= 30 && t.x < 30 + width && t.y >= 30 && t.y < 30 + height;
        const vec3 color(0.5f, 1.0f, 2.0f);
        IrradianceEstimate e;
        e.irradiance = color * ((odd ? light : 1.0f) / luminance(color));
        e.moment = vec3(0.0f, 0.5f, 0.0f) * (odd ? light : 1.0f);
        e.varianceOfMean = 0.0004f;
        e.samples = samples;
        return e;
    }
    void check(const OneChart& chart, float tolerance) const
    {
        SCOPED_TRACE(testing::Message() << width << " x " << height << " of " << light << ", " << samples
                                        << " samples");
        const auto estimates = chart.denoised([&](const Texel& t) { return estimateOf(t); }, true);
        const IrradianceEstimate& e = estimates[chart.at(30 + width / 2, 30 + height / 2)];
        EXPECT_NEAR(luminance(e.irradiance), expected, tolerance);
        EXPECT_NEAR(e.irradiance.x / e.irradiance.z, 0.25f, 0.01f);
        EXPECT_NEAR(e.moment.y, 0.5f * expected, tolerance);
    }
};

/// A texel, or two side by side, brighter than all around though its blocks agree: that is luck when these are few, and
/// light when they are many or when more texels have it.
TEST(DenoiseS6, FewBlocksAgreeByChance)
{
    const OneChart chart(vec2(4), vec2(60));
    for (const OddTexels& bright :
         {OddTexels{1, 1, 2.0f, 32, 1.0f}, {2, 1, 2.0f, 32, 1.0f}, {2, 2, 2.0f, 32, 2.0f}, {1, 1, 2.0f, 256, 2.0f}})
        bright.check(chart, 0.1f);
}

/// The same of one that is darker.
TEST(DenoiseS6, DarkSpecksGoAndShadowsStay)
{
    const OneChart chart(vec2(4), vec2(60));
    for (const OddTexels& dark : {OddTexels{1, 1, 0.5f, 32, 1.0f},
                                  {1, 1, 0.0f, 32, 1.0f},
                                  {2, 2, 0.5f, 32, 0.5f},
                                  {8, 1, 0.5f, 32, 0.5f},
                                  {1, 1, 0.5f, 256, 0.5f}})
        dark.check(chart, 0.05f);
}

/// Few rays of many texels meet something bright: texels in which one did, and whose variance says so, do not stay
/// brighter than the others, be they one in fifty or every other one.
TEST(DenoiseS6, SpreadsDotsThatAreMany)
{
    const auto [geometry, map] = OneChart(vec2(4), vec2(60));
    constexpr int kParts = 8; // of a texel's samples, which tell of its variance
    constexpr float kHit = 4.0f;
    for (const float share : {0.02f, 0.05f, 0.1f, 0.15f, 0.2f, 0.3f, 0.5f}) {
        SCOPED_TRACE(testing::Message() << share << " of the texels");
        std::mt19937 random(11);
        std::uniform_real_distribution<float> unit;
        std::normal_distribution<float> noise(0.0f, 0.05f);
        std::vector<IrradianceEstimate> estimates(map.texels.size());
        for (IrradianceEstimate& e : estimates) {
            float sum = 0.0f;
            float squares = 0.0f;
            for (int part = 0; part < kParts; ++part) {
                const float value = 1.0f + noise(random) + (unit(random) < share / float(kParts) ? kHit : 0.0f);
                sum += value;
                squares += value * value;
            }
            const float mean = sum / float(kParts);
            e.irradiance = vec3(mean);
            e.varianceOfMean = (squares / float(kParts) - mean * mean) / float(kParts - 1);
            e.samples = 256;
        }
        denoise(geometry, map, {}, estimates);
        // Away from the rim, where fewer are around.
        int dots = 0;
        for (std::size_t i = 0; i < estimates.size(); ++i) {
            const Texel& t = map.texels[i];
            if (t.x < 8 || t.x >= 56 || t.y < 8 || t.y >= 56) continue;
            const float expected = 1.0f + share * kHit / float(kParts);
            dots += estimates[i].irradiance.x > expected + 0.4f * kHit / float(kParts) ? 1 : 0;
        }
        EXPECT_LE(dots, 2);
    }
}

/// First moments are denoised where a directional lightmap needs them, as their light is; light is the same either way.
TEST(DenoiseS6, DirectionsAreDenoisedWhereAskedFor)
{
    const auto [geometry, map] = OneChart(vec2(0), vec2(64));
    std::mt19937 random(5);
    constexpr float kSigma = 0.1f;
    std::normal_distribution<float> noise(0.0f, kSigma);
    std::vector<IrradianceEstimate> noisy(map.texels.size());
    for (IrradianceEstimate& e : noisy) {
        e.irradiance = vec3(1.0f + noise(random));
        e.moment = vec3(noise(random), 0.5f + noise(random), noise(random));
        e.varianceOfMean = kSigma * kSigma;
        e.samples = 64;
    }
    std::vector<IrradianceEstimate> with = noisy;
    std::vector<IrradianceEstimate> without = noisy;
    denoise(geometry, map, {}, with, true);
    denoise(geometry, map, {}, without, false);
    const auto squares = [&](const std::vector<IrradianceEstimate>& estimates) {
        double sum = 0.0;
        for (const IrradianceEstimate& e : estimates)
            sum += double(glm::dot(e.moment - vec3(0, 0.5f, 0), e.moment - vec3(0, 0.5f, 0)));
        return sum;
    };
    EXPECT_LT(squares(with), 0.1 * squares(noisy));
    for (std::size_t i = 0; i < noisy.size(); ++i) {
        ASSERT_EQ(with[i].irradiance, without[i].irradiance);
        ASSERT_EQ(with[i].varianceOfMean, without[i].varianceOfMean);
    }
    EXPECT_GT(squares(without), 0.5 * squares(noisy));
}

/// A contact shadow, steep at the foot: where texels state far more variance than their noise has, as well-spread
/// samples do, what their neighbours show counts, and the shadow stays.
TEST(DenoiseS6, TrustsNeighboursMoreThanStatedVariance)
{
    const auto truth = [](const Texel& t) {
        const float texels = std::abs(float(t.x) - 20.0f);
        return 1.0f - 0.15f * std::exp(-texels);
    };
    for (const float stated : {1.0f, 9.0f}) {
        const NoisyPage page(truth, 0.02f, 0.02f * 0.02f * stated);
        EXPECT_LT(page.after, 0.12 * page.before) << "variance stated " << stated << " times too high";
    }
}

} // namespace
} // namespace halflight::test::denoise_test
