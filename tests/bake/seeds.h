#pragma once
// Estimates judged by what they differ by from seed to seed. Limits in per cent are either within noise, so that chance
// decides, or too wide to see a fault. Variances that the bake states are no measure: they are too large on purpose.

#include "bake/test_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

namespace halflight::test {

/// The fewest from which a spread can be told.
inline constexpr int kSeeds = 8;
/// A mean lies farther off by chance once in 200 times with eight seeds, once in 900 with sixteen (Student's t).
inline constexpr double kStandardErrors = 4.0;
/// Of numbers in float.
inline constexpr double kRounding = 2.0e-5;

struct SeedMean {
    double mean = 0.0;
    double error = 0.0; ///< standard error of the mean, from the spread between the seeds
};

inline SeedMean meanOf(const std::vector<double>& values)
{
    SeedMean m;
    const auto count = double(values.size());
    for (const double v : values) m.mean += v / count;
    double squares = 0.0;
    for (const double v : values) squares += (v - m.mean) * (v - m.mean);
    m.error = std::sqrt(squares / (count - 1.0) / count);
    return m;
}

/// Of `value(seed)`.
template<typename Value> SeedMean overSeeds(const Value& value, int seeds = kSeeds)
{
    std::vector<double> values;
    for (int seed = 1; seed <= seeds; ++seed) values.push_back(double(value(uint32_t(seed))));
    return meanOf(values);
}

/// What is the same in all bakes.
struct SameBake {
    Scene scene;
    IntegrationSettings settings;
    int pageSize = 64;
};
using Estimates = std::vector<IrradianceEstimate>;

/// Lightmaps that differ in their seed alone.
inline std::vector<Estimates> bakedBySeeds(const SameBake& bake, int seeds = kSeeds)
{
    std::vector<Estimates> all;
    for (int seed = 1; seed <= seeds; ++seed) {
        IntegrationSettings settings = bake.settings;
        settings.seed = uint32_t(seed);
        Bench bench(bake.scene, MixedLightingMode::Shadowmask, bake.pageSize, settings);
        all.push_back(bench.irradiance());
    }
    return all;
}

/// Mean over a lightmap's valid texels.
template<typename Value> double meanOverTexels(const Estimates& estimates, const Value& value)
{
    double sum = 0.0;
    double count = 0.0;
    for (const IrradianceEstimate& e : estimates) {
        if (!e.valid) continue;
        sum += double(value(e));
        count += 1.0;
    }
    return sum / count;
}
inline double meanIrradiance(const Estimates& estimates)
{
    return meanOverTexels(estimates, [](const IrradianceEstimate& e) { return e.irradiance.y; });
}
inline double meanLuminance(const Estimates& estimates)
{
    return meanOverTexels(estimates, [](const IrradianceEstimate& e) { return luminance(e.irradiance); });
}

inline SeedMean meanIrradiance(const std::vector<Estimates>& all)
{
    std::vector<double> means;
    for (const Estimates& estimates : all) means.push_back(meanIrradiance(estimates));
    return meanOf(means);
}

/// Each texel's mean over the bakes.
inline Estimates meanOverSeeds(const std::vector<Estimates>& all)
{
    Estimates mean = all.front();
    for (IrradianceEstimate& e : mean) e.irradiance = e.moment = vec3(0.0f);
    for (const Estimates& estimates : all) {
        for (std::size_t i = 0; i < mean.size(); ++i) {
            mean[i].irradiance += estimates[i].irradiance / float(all.size());
            mean[i].moment += estimates[i].moment / float(all.size());
        }
    }
    return mean;
}

/// Squared standard error of a texel's mean luminance, in the mean over the valid texels.
inline double squaredNoise(const std::vector<Estimates>& all)
{
    double sum = 0.0;
    double count = 0.0;
    for (std::size_t i = 0; i < all.front().size(); ++i) {
        if (!all.front()[i].valid) continue;
        std::vector<double> values;
        for (const Estimates& estimates : all) values.push_back(double(luminance(estimates[i].irradiance)));
        const SeedMean texel = meanOf(values);
        sum += texel.error * texel.error;
        count += 1.0;
    }
    return sum / count;
}

inline SeedMean operator*(SeedMean m, double factor)
{
    return {m.mean * factor, m.error * std::abs(factor)};
}

/// Shares of the expected value.
struct Limits {
    double resolved = 0.01; ///< four standard errors stay below it: what too few samples let pass shows nothing
    double bias = 0.0;      ///< by which a method is off by its design, and says so
};

/// The same by two ways.
inline void expectSameMean(SeedMean found, SeedMean expected, Limits limits)
{
    const double noise = kStandardErrors * std::hypot(found.error, expected.error);
    const double size = std::abs(expected.mean);
    EXPECT_LT(noise, limits.resolved * size) << "too few samples to show anything";
    EXPECT_NEAR(found.mean, expected.mean, noise + (limits.bias + kRounding) * size);
}
inline void expectMean(SeedMean found, double expected, Limits limits)
{
    expectSameMean(found, {expected, 0.0}, limits);
}

} // namespace halflight::test
