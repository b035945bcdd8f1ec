// How many samples texels get, and the noise that is left (spec S6).

#include "bake/test_room.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace halflight::test::adaptive_sampling_test {
namespace {

constexpr int kPage = 64;

/// The error is near the target, a lower target takes more samples, and smooth places take fewer than others.
TEST(AdaptiveSamplingS6, ReachesItsTarget)
{
    const auto reference = bakeWith(room(true, false, true), IntegratorKind::Cache, 2048, 3);
    double before = 0.0;
    for (const float target : {0.08f, 0.04f, 0.02f}) {
        const auto estimates = bakeWith(room(true, false, true), IntegratorKind::Cache, 4096, 3, target);
        std::vector<double> errors;
        double samples = 0.0;
        uint32_t fewest = ~0u;
        uint32_t most = 0;
        for (std::size_t i = 0; i < estimates.size(); ++i) {
            if (!estimates[i].valid) continue;
            const float l = luminance(reference[i].irradiance);
            errors.push_back(std::pow(double(luminance(estimates[i].irradiance) - l) / double(l), 2.0));
            samples += double(estimates[i].samples);
            fewest = std::min(fewest, estimates[i].samples);
            most = std::max(most, estimates[i].samples);
        }
        double sum = 0.0;
        for (const double e : errors) sum += e;
        const double rms = std::sqrt(sum / double(errors.size()));
        EXPECT_LT(rms, 1.1 * double(target)) << "target " << target;
        EXPECT_GT(rms, 0.2 * double(target)) << "target " << target;
        EXPECT_GT(samples, 1.5 * before) << "target " << target;
        EXPECT_LT(2 * fewest, most) << "target " << target;
        before = samples;
    }
}

/// Texels with few neighbours, over which no denoiser can average, take more samples.
TEST(RadianceCacheS6, TexelsThatStandAloneGetMoreSamples)
{
    Scene scene;
    scene.sky = {vec3(1), vec3(1), vec3(1)};
    const int white = addMaterial(scene, vec3(0.8f), vec3(0.0f), true);
    addRectangle(scene, {vec3(-4, 0, 4), vec3(8, 0, 0), vec3(0, 0, -8)}, white, kPage, {vec2(1), vec2(33)});
    addRectangle(scene, {vec3(-1, 1, 1), vec3(1, 0, 0), vec3(0, 0, -1)}, white, kPage, {vec2(40), vec2(42)});
    IntegrationSettings settings;
    settings.samples = 32;
    Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, settings);
    const auto estimates = bench.irradiance();
    double middle = 0.0;
    int middleCount = 0;
    double alone = 0.0;
    int aloneCount = 0;
    for (std::size_t i = 0; i < estimates.size(); ++i) {
        const Texel& t = bench.map.texels[i];
        const bool inTheMiddle = t.x > 3 && t.x < 30 && t.y > 3 && t.y < 30;
        if (t.x >= 40) alone += double(estimates[i].samples);
        if (t.x >= 40) ++aloneCount;
        if (inTheMiddle) middle += double(estimates[i].samples);
        if (inTheMiddle) ++middleCount;
    }
    EXPECT_GE(alone / aloneCount, 4.0 * middle / middleCount);
    EXPECT_LE(middle / middleCount, 32.0);
}

/// A floor under a black roof with a hole in every so many squares of a fine pattern, and the sky above it; another
/// floor far away in the open.
Bench underHoles(int every, float height = 0.3f, bool denoised = true)
{
    Scene scene;
    scene.sky = {vec3(1000), vec3(0), vec3(0)}; // none comes in below the roof's edges
    ImageRgba8 pixels(256, 256, u8vec4(255));
    for (int y = 0; y < 256; y += every) {
        for (int x = 0; x < 256; x += every) pixels(x, y).w = 0;
    }
    const int white = addMaterial(scene, vec3(0.8f), vec3(0.0f), true);
    const int black = addMaterialWithHoles(scene, vec3(0.0f), std::move(pixels), true);
    addRectangle(scene, {vec3(-1, 0, 1), vec3(2, 0, 0), vec3(0, 0, -2)}, white, kPage, {vec2(1), vec2(33)});
    addRectangle(scene, {vec3(-4, height, -4), vec3(8, 0, 0), vec3(0, 0, 8)}, black, kPage);
    addRectangle(scene, {vec3(49, 0, 1), vec3(2, 0, 0), vec3(0, 0, -2)}, white, kPage, {vec2(35, 1), vec2(63, 29)});
    IntegrationSettings settings;
    settings.samples = 32;
    settings.cache.denoised = denoised;
    return Bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, settings);
}

/// Mean samples of the texels under the roof over those of the texels in the open, in the middle of each floor.
double timesUnderTheRoof(Bench& bench)
{
    const auto estimates = bench.irradiance();
    double sum[2] = {0.0, 0.0};
    int count[2] = {0, 0};
    for (std::size_t i = 0; i < estimates.size(); ++i) {
        const Texel& t = bench.map.texels[i];
        const bool open = t.x > 33;
        const int left = open ? 38 : 4;
        if (t.x < left || t.x > left + 21 || t.y < 4 || t.y > 25) continue;
        EXPECT_GE(estimates[i].samples, 16u);
        EXPECT_LE(estimates[i].samples, 32u * 32u);
        sum[open ? 1 : 0] += double(estimates[i].samples);
        ++count[open ? 1 : 0];
    }
    EXPECT_GT(count[0], 400);
    EXPECT_GT(count[1], 400);
    return sum[0] / count[0] * count[1] / sum[1];
}

/// Texels take more samples where the whole neighbourhood is noisy. They do not where a few rays in a thousand hit
/// light: a denoiser removes such outliers.
TEST(NoiseS6, MoreSamplesWhereMostAreNoisy)
{
    Bench often = underHoles(4);
    EXPECT_GT(timesUnderTheRoof(often), 1.6);
    Bench seldom = underHoles(32);
    EXPECT_LT(timesUnderTheRoof(seldom), 1.3);
}

/// A denoiser averages over neighbours where rays end many texels away, not where they end near by. With a denoiser,
/// the samples go to the latter.
TEST(NoiseS6, MoreSamplesWhereNeighboursTellLittle)
{
    const auto timesOf = [](float height, bool denoised) {
        Bench bench = underHoles(4, height, denoised);
        return timesUnderTheRoof(bench);
    };
    EXPECT_GT(timesOf(0.05f, true), 1.1 * timesOf(0.05f, false));
    EXPECT_LT(timesOf(1.0f, true), 0.9 * timesOf(1.0f, false));
}

/// The mean over the texels is the number of samples asked for.
TEST(NoiseS6, SamplesAreAsManyAsAskedForOnAverage)
{
    for (const bool denoised : {true, false}) {
        for (const int samples : {16, 24, 32, 100, 1024}) {
            if (samples > 100 && denoised) continue; // takes long
            Bench made = underHoles(4, 0.3f, denoised);
            IntegrationSettings settings;
            settings.samples = samples;
            settings.cache.denoised = denoised;
            Bench bench(std::move(made.scene), MixedLightingMode::Shadowmask, kPage, settings);
            double sum = 0.0;
            int valid = 0;
            for (const IrradianceEstimate& e : bench.irradiance()) {
                sum += double(e.samples);
                valid += e.valid ? 1 : 0;
            }
            EXPECT_NEAR(sum / valid, double(samples), 0.1 * samples) << (denoised ? "denoised" : "");
        }
    }
}

/// Variance falls as the samples grow: of four times as many, a quarter at most of the squared differences from the
/// truth.
TEST(NoiseS6, FourTimesTheSamplesAQuarterOfTheVariance)
{
    const auto estimatesOf = [](int samples, uint32_t seed) {
        Bench made = underHoles(4, 0.3f, false);
        IntegrationSettings settings;
        settings.samples = samples;
        settings.cache.denoised = false;
        settings.seed = seed;
        Bench bench(std::move(made.scene), MixedLightingMode::Shadowmask, kPage, settings);
        return bench.irradiance();
    };
    const auto truth = estimatesOf(2048, 2);
    double before = 0.0;
    for (const int samples : {16, 64, 256}) {
        const auto estimates = estimatesOf(samples, 1);
        double squares = 0.0;
        for (std::size_t i = 0; i < truth.size(); ++i)
            squares += std::pow(double(estimates[i].irradiance.x - truth[i].irradiance.x), 2.0);
        if (samples > 16) EXPECT_LT(squares, 0.3 * before) << samples;
        before = squares;
    }
}

} // namespace
} // namespace halflight::test::adaptive_sampling_test
