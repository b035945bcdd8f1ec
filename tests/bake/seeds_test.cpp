// The judge of means over seeds is judged: it sees a fault of the size it says, and lets noise pass.

#include "bake/seeds.h"

#include "halflight/shading/random.h"

#include <gtest/gtest-spi.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

namespace halflight::test::seeds_test {
namespace {

/// Evenly spread numbers about 1, their means over 100, by seed.
SeedMean noisy(uint32_t trial, double mean = 1.0)
{
    return overSeeds([&](uint32_t seed) {
        double sum = 0.0;
        for (uint32_t i = 0; i < 100; ++i)
            sum += mean + 0.2 * (double(unitFloat(hashCombine(hashCombine(trial, seed), i))) - 0.5);
        return sum / 100.0;
    });
}

TEST(Seeds, StandardErrorIsThatOfTheMeanOverAllSeeds)
{
    double squares = 0.0;
    double stated = 0.0;
    for (uint32_t trial = 0; trial < 400; ++trial) {
        const SeedMean m = noisy(trial);
        squares += (m.mean - 1.0) * (m.mean - 1.0) / 400.0;
        stated += m.error * m.error / 400.0;
    }
    // An even spread of width w has the variance w^2 / 12.
    const double expected = 0.2 * 0.2 / 12.0 / (100.0 * kSeeds);
    EXPECT_NEAR(stated, expected, 0.1 * expected);
    EXPECT_NEAR(squares, expected, 0.2 * expected);
}

TEST(Seeds, SeeAFaultAndNotTheNoise)
{
    expectMean(noisy(1), 1.0, {.resolved = 0.02});
    expectSameMean(noisy(1), noisy(2), {.resolved = 0.02});
    EXPECT_NONFATAL_FAILURE(expectMean(noisy(1, 1.03), 1.0, {.resolved = 0.02}), "found.mean");
    EXPECT_NONFATAL_FAILURE(expectSameMean(noisy(1, 1.03), noisy(2), {.resolved = 0.02}), "found.mean");
    EXPECT_NONFATAL_FAILURE(expectMean(noisy(1), 1.0, {.resolved = 0.001}), "too few samples");
}

} // namespace
} // namespace halflight::test::seeds_test
