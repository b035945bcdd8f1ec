#include "bake/denoise/denoise.h"

#include "halflight/base/parallel.h"

#include <algorithm>
#include <cstdint>
#include <optional>

namespace halflight {
namespace {

/// Squared second difference at a texel, and its expectation under the variances that the estimates state.
struct SecondDifference {
    float measured = 0.0f;
    float expected = 0.0f;
};

/// Second difference along both axes of 3 × 3 texels, `distance` apart. Light that is linear along one axis or the
/// other cancels, so that noise remains (Immerkaer 1996, "Fast Noise Variance Estimation"). Nothing where one is
/// missing on the chart: texels beyond seams lie off the grid.
std::optional<SecondDifference> secondDifference(const SurfaceGrid& grid, std::span<const IrradianceEstimate> estimates,
                                                 std::size_t texel, int distance)
{
    float difference = 0.0f;
    float variance = 0.0f;
    int count = 0;
    for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
            const uint32_t j = grid.onChart(uint32_t(texel), dx * distance, dy * distance);
            if (j == kNoTexel || !isTraced(estimates[j])) continue;
            const float weight = float((dx == 0 ? -2 : 1) * (dy == 0 ? -2 : 1));
            const NoisyLight light = gatheredOf(estimates[j]);
            difference += weight * luminance(light.irradiance);
            variance += weight * weight * light.variance;
            ++count;
        }
    }
    if (count < 9) return std::nullopt;
    return SecondDifference{difference * difference, variance};
}

} // namespace

std::vector<float> varianceScales(const SurfaceGrid& grid, std::span<const IrradianceEstimate> estimates)
{
    // Traced texels are 1, 2 or 4 texels apart: the smallest complete 3 × 3 counts.
    std::vector<SecondDifference> differences(estimates.size());
    parallelFor(estimates.size(), 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            if (!isTraced(estimates[i])) continue;
            for (int distance = 1; distance <= 4; distance *= 2) {
                const auto difference = secondDifference(grid, estimates, i, distance);
                if (!difference) continue;
                differences[i] = *difference;
                break;
            }
        }
    });
    constexpr int kRadius = 3; // texels: 49 differences, a standard error of 20 % of their mean square
    std::vector<float> scales(estimates.size(), 1.0f);
    parallelFor(estimates.size(), 2048, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            float measured = 0.0f;
            float expected = 0.0f;
            float count = 0.0f;
            grid.aroundOnChart(uint32_t(i), kRadius, [&](uint32_t j) {
                measured += differences[j].measured;
                expected += differences[j].expected;
                count += differences[j].expected > 0.0f ? 1.0f : 0.0f;
            });
            // One more difference, as large as stated: few ones prove little, and differences of 0 by chance must not
            // switch the filter off.
            if (count > 0.0f) scales[i] = std::min((count * measured / expected + 1.0f) / (count + 1.0f), 1.0f);
        }
    });
    return scales;
}

} // namespace halflight
