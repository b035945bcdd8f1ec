// Outliers of gathered light: fireflies (few paths with a large contribution) and dark specks (no path with one).
#include "bake/denoise/denoise.h"

#include "bake/texels/texel_places.h"

#include "halflight/base/parallel.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace halflight {
namespace {

/// Adjacent texels that hold this share of an outlier's excess confirm it: the light is real.
constexpr float kConfirmingShare = 0.25f;
constexpr uint32_t kReliableSamples = 128; ///< from there on chance does not explain a difference
constexpr int kFewestNeighbours = 8;       ///< below, quantiles of the neighbourhood mean nothing

/// The value of the given rank in ascending order.
float valueOfRank(std::span<const float> values, int rank)
{
    std::array<float, NeighbourStats::kMaxCount> sorted;
    const auto end = std::copy(values.begin(), values.end(), sorted.begin());
    std::nth_element(sorted.begin(), sorted.begin() + rank, end);
    return sorted[std::size_t(rank)];
}

/// valueOfRank(values, rank) > bound, in one pass.
bool rankIsAbove(std::span<const float> values, int rank, float bound)
{
    const auto above = std::count_if(values.begin(), values.end(), [&](float v) { return v > bound; });
    return above >= std::ptrdiff_t(values.size()) - rank;
}

/// Ranks of the 1/8 and the 7/8 quantile.
int lowRank(int count)
{
    return count / 8;
}
int highRank(int count)
{
    return count - count / 8;
}

std::span<const float> luminancesOf(const NeighbourStats& stats)
{
    return {stats.luminances.data(), std::size_t(stats.count)};
}

/// Whether a texel lies in the midst of a surface.
bool isAmid(const NeighbourStats& stats, const OutlierTexel& texel)
{
    return texel.isWhole && stats.adjacentCount * stats.step >= 8;
}

/// Few samples, in the midst of a surface. Half blocks agree by chance in one of some thousand such texels, so that a
/// small stated variance does not prove light to be real.
bool mayAgreeByChance(const NeighbourStats& stats, const OutlierTexel& texel)
{
    return isAmid(stats, texel) && texel.samples < kReliableSamples;
}

/// For a texel below the 1/8 quantile: that quantile, if the texel is a dark speck.
float raisedLuminance(const NeighbourStats& stats, const OutlierTexel& texel, float variance)
{
    const float dark = valueOfRank(luminancesOf(stats), lowRank(stats.count));
    const float lack = dark - texel.luminance;
    const bool alone = dark - stats.darkestAdjacent.y < kConfirmingShare * lack;
    return alone && lack > 0.5f * std::sqrt(variance) ? dark : texel.luminance;
}

/// For a texel above the 7/8 quantile: that quantile, if the texel is a firefly. A path with a large contribution makes
/// the half blocks of its texel differ by about the excess. Where they agree, the light is real, unless no adjacent
/// texel confirms it and chance explains it. The limit is lower at rims, where real differences are common, and where
/// adjacent texels confirm the light: a lamp close to a wall lights few texels.
float loweredLuminance(const NeighbourStats& stats, const OutlierTexel& texel, float variance)
{
    const float bright = valueOfRank(luminancesOf(stats), highRank(stats.count));
    const float excess = texel.luminance - bright;
    const bool confirmed = stats.brightestAdjacent.y - bright >= kConfirmingShare * excess;
    const bool alone = mayAgreeByChance(stats, texel) && !confirmed;
    const float sigmas = !texel.isWhole ? 2.0f : confirmed ? 3.0f : 5.0f;
    const bool isNoise = alone || excess <= sigmas * std::sqrt(texel.statedVariance);
    const bool isFirefly = excess > 0.5f * std::sqrt(variance) && isNoise;
    return isFirefly ? bright : texel.luminance;
}

/// Covered for the most part, and all of its sample points are valid.
bool isWhole(const TexelMap& map, const Texel& texel)
{
    return coveredArea(map, texel) > kMostlyCovered && texel.validPoints == kAllPoints;
}

/// Scales the first moment as the luminance of all light changes, so that the mean direction stays.
void scaleMoment(vec3& moment, const IrradianceEstimate& estimate, float before, float after)
{
    const float direct = luminance(estimate.direct);
    if (before + direct > 0.0f) moment *= (after + direct) / (before + direct);
}

void lower(NoisyLight& light, vec3& moment, const IrradianceEstimate& estimate, float before, float after)
{
    light.irradiance *= after / before;
    scaleMoment(moment, estimate, before, after);
}

/// The added light has the mean colour of the neighbours: a black texel has no colour of its own.
void raise(NoisyLight& light, vec3& moment, const IrradianceEstimate& estimate, float before, float after,
           vec3 neighbours)
{
    light.irradiance += neighbours * ((after - before) / luminance(neighbours));
    scaleMoment(moment, estimate, before, after);
}

/// 1, or 2 where so many texels are interpolated that too few traced ones are in the 5 × 5.
int stepAround(const SurfaceGrid& grid, std::span<const IrradianceEstimate> estimates, uint32_t texel)
{
    int interpolated = 0;
    grid.around(texel, 2, [&](uint32_t j) { interpolated += isInterpolated(estimates[j]) ? 1 : 0; });
    return interpolated >= kFewestNeighbours ? 2 : 1;
}

/// Interpolated texels beside a clamped outlier hold a share of it: their limit is the brightest adjacent traced texel.
void clampInterpolated(const SurfaceGrid& grid, std::span<const IrradianceEstimate> estimates,
                       std::span<const NoisyLight> before, std::vector<NoisyLight>& light, std::vector<vec3>& moments)
{
    parallelFor(light.size(), 2048, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            if (!isInterpolated(estimates[i])) continue;
            bool clamped = false;
            float brightest = 0.0f;
            grid.around(uint32_t(i), 1, [&](uint32_t j) {
                if (!isTraced(estimates[j])) return;
                clamped = clamped || light[j].irradiance != before[j].irradiance;
                brightest = std::max(brightest, luminance(light[j].irradiance));
            });
            const float own = luminance(light[i].irradiance);
            if (clamped && own > brightest) lower(light[i], moments[i], estimates[i], own, brightest);
        }
    });
}

} // namespace

NeighbourStats neighbourStats(const SurfaceGrid& grid, std::span<const IrradianceEstimate> estimates,
                              std::span<const NoisyLight> light, uint32_t texel, int step)
{
    NeighbourStats stats;
    stats.step = step;
    const bool tracedOnly = isTraced(estimates[texel]);
    float varianceSum = 0.0f;
    for (int dy = -2 * step; dy <= 2 * step; ++dy) {
        for (int dx = -2 * step; dx <= 2 * step; ++dx) {
            const uint32_t j = grid.at(texel, dx, dy);
            if (j == kNoTexel || !estimates[j].valid || (tracedOnly && !isTraced(estimates[j]))) continue;
            if (j != texel) {
                const float other = luminance(light[j].irradiance);
                stats.irradianceSum += light[j].irradiance;
                stats.luminances[std::size_t(stats.count)] = other;
                stats.variances[std::size_t(stats.count++)] = light[j].variance;
                if (std::max(std::abs(dx), std::abs(dy)) <= step) {
                    ++stats.adjacentCount;
                    vec2& bright = stats.brightestAdjacent;
                    vec2& dark = stats.darkestAdjacent;
                    bright = {std::max(bright.x, other), std::max(bright.y, std::min(bright.x, other))};
                    dark = {std::min(dark.x, other), std::min(dark.y, std::max(dark.x, other))};
                }
            }
            const float w = 1.0f / (1.0f + float(dx * dx + dy * dy) / float(step * step));
            varianceSum += w * std::min(light[j].variance, 4.0f * light[texel].variance + 1.0e-12f);
            stats.varianceWeight += w;
        }
    }
    if (stats.varianceWeight > 0.0f) stats.meanVariance = varianceSum / stats.varianceWeight;
    return stats;
}

// A variance estimate is noisy itself, so it is averaged with its neighbours'. The clamp to 4 × its own value keeps the
// variance beside a bright light from opening a dark texel's filter. A texel without a bright path has a variance near
// zero by chance: the median of its neighbourhood is a lower bound, and in the midst of a surface half the 7/8
// quantile.
float smoothedVariance(const NeighbourStats& stats, const OutlierTexel& texel)
{
    const std::span<const float> variances(stats.variances.data(), std::size_t(stats.count));
    float variance = texel.variance;
    if (stats.varianceWeight > 0.0f) variance = std::max(stats.meanVariance, 0.25f * texel.variance);
    const int median = stats.count / 2;
    if (stats.count > 0 && rankIsAbove(variances, median, variance)) variance = valueOfRank(variances, median);
    const int high = highRank(stats.count);
    if (isAmid(stats, texel) && rankIsAbove(variances, high, 2.0f * variance))
        variance = 0.5f * valueOfRank(variances, high);
    return variance;
}

float luminanceWithoutOutliers(const NeighbourStats& stats, const OutlierTexel& texel, float variance)
{
    const float own = texel.luminance;
    if (!texel.isTraced || stats.count < kFewestNeighbours) return own;
    const std::span<const float> luminances = luminancesOf(stats);
    const bool isDark = mayAgreeByChance(stats, texel) && rankIsAbove(luminances, lowRank(stats.count), own);
    if (isDark) return raisedLuminance(stats, texel, variance);
    if (rankIsAbove(luminances, highRank(stats.count), own)) return own;
    return loweredLuminance(stats, texel, variance);
}

void clampOutliers(const TexelMap& map, const SurfaceGrid& grid, std::span<const IrradianceEstimate> estimates,
                   std::vector<NoisyLight>& light, std::vector<vec3>& moments)
{
    const std::vector<NoisyLight> before = light;
    const bool anyInterpolated = std::any_of(estimates.begin(), estimates.end(), isInterpolated);
    parallelFor(light.size(), 2048, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const bool traced = isTraced(estimates[i]);
            const int step = traced && anyInterpolated ? stepAround(grid, estimates, uint32_t(i)) : 1;
            const NeighbourStats stats = neighbourStats(grid, estimates, before, uint32_t(i), step);
            const OutlierTexel texel = {luminance(before[i].irradiance),
                                        before[i].variance,
                                        gatheredOf(estimates[i]).variance,
                                        estimates[i].samples,
                                        traced,
                                        isWhole(map, map.texels[i])};
            light[i].variance = smoothedVariance(stats, texel);
            const float after = luminanceWithoutOutliers(stats, texel, light[i].variance);
            if (after > texel.luminance) {
                raise(light[i], moments[i], estimates[i], texel.luminance, after, stats.irradianceSum);
            } else if (after < texel.luminance) {
                lower(light[i], moments[i], estimates[i], texel.luminance, after);
            }
        }
    });
    if (anyInterpolated) clampInterpolated(grid, estimates, before, light, moments);
}

} // namespace halflight
