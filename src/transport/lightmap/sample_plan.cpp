#include "transport/lightmap/sample_plan.h"

#include "halflight/base/mathematics.h"
#include "halflight/base/parallel.h"
#include "halflight/shading/random.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace halflight {
namespace {

/// First blocks of all texels if there is a noise target.
constexpr int kFirstBlocks = 2;
/// Bounds of a texel's samples relative to the samples asked for, without a noise target.
constexpr float kFewestTimes = 0.5f;
constexpr float kMostTimes = 32.0f;
/// Standard deviation of a half-block, relative to the light, at which the demand is 1. The light is the geometric mean
/// of the neighbourhood's mean (once) and the map's mean (three times).
constexpr float kNoise = 0.15f;
/// The share of the noise that remains after denoising grows with w / d, where texels are w wide and rays end at
/// distance d: about (w / d)^(2/3), from 5 % at 0.02 to nearly all from 2 on (`bench_bake error`). The demand is
/// proportional to the root of that share.
constexpr float kDetail = 1.4f;
/// The scale is rounded to 1/16 of a power of two, so that a small change of the scene does not change it.
constexpr float kScaleSteps = 16.0f;
constexpr float kMostSteps = 10.0f * kScaleSteps; ///< a factor of 1024 up or down

} // namespace

SamplePlan::SamplePlan(const IntegrationSettings& settings, const BakeGeometry& geometry, const TexelMap& map,
                       const TexelGrid& grid, float mapMean, int samples, float scale)
    : settings_(settings), geometry_(geometry), map_(map), grid_(grid), mapMean_(mapMean),
      blocks_(float(samples) / float(StratifiedPattern::kBlock)), scale_(scale)
{}

int SamplePlan::firstBlocks() const
{
    const int fewest = std::max(1, int(std::lround(kFewestTimes * blocks_)));
    return hasTarget() ? std::min(fewest, kFirstBlocks) : fewest;
}

int SamplePlan::mostBlocks() const
{
    return int(std::ceil(hasTarget() ? blocks_ : kMostTimes * blocks_));
}

float SamplePlan::clampBlocks(float times) const
{
    return std::clamp(times * blocks_, float(firstBlocks()), float(std::max(mostBlocks(), firstBlocks())));
}

std::vector<TexelDemand> SamplePlan::demands(const TexelSet& wanted, const TexelStates& states) const
{
    std::vector<TexelDemand> demands(states.texels.size());
    parallelFor(demands.size(), 1024, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const uint32_t texel = states.texels[i];
            if (states.states[i].valid && wanted.contains(texel)) demands[i] = {texel, demand(texel, states)};
        }
    });
    std::erase_if(demands, [](const TexelDemand& d) { return d.times == 0.0f; });
    return demands;
}

float SamplePlan::scaleOf(std::span<const TexelDemand> demands) const
{
    if (demands.empty()) return 1.0f;
    const auto mean = [&](float scale) {
        double sum = 0.0;
        for (const TexelDemand& d : demands) sum += double(clampBlocks(scale * d.times)) / double(demands.size());
        return sum;
    };
    // Bisection; the mean grows with the scale, from the fewest blocks to the most.
    float low = -kMostSteps;
    float high = kMostSteps;
    while (high - low > 1.0f) {
        const float middle = std::floor(0.5f * (low + high));
        (mean(math::exp2(middle / kScaleSteps)) < double(blocks_) ? low : high) = middle;
    }
    const auto error = [&](float steps) { return std::abs(mean(math::exp2(steps / kScaleSteps)) - double(blocks_)); };
    return math::exp2((error(low) <= error(high) ? low : high) / kScaleSteps);
}

/// A texel takes one of the two steps around its number of blocks, at random, so that the mean is that number.
int SamplePlan::blocksForDemand(uint32_t texel, const TexelStates& states) const
{
    const float blocks = clampBlocks(scale_ > 0.0f ? scale_ * demand(texel, states) : 1.0f);
    int below = firstBlocks();
    while (below < mostBlocks() && float(nextStep(below)) <= blocks) below = nextStep(below);
    const int above = nextStep(below);
    if (above <= below) return below;
    const Texel& t = map_.texels[texel];
    const float probability = (blocks - float(below)) / float(above - below);
    return unitFloat(hashCombine(hashCombine(t.page, t.x), t.y)) < probability ? above : below;
}

/// A texel's samples relative to the samples asked for, before the scale.
float SamplePlan::demand(uint32_t texel, const TexelStates& states) const
{
    const Noise noise = noiseAround(texel, states);
    // The denoiser averages over the neighbours that exist.
    const float fewest = kFewestTimes * float(kAround) / float(noise.texels);
    const float light = std::sqrt(std::sqrt(noise.mean * mapMean_) * mapMean_);
    const float factor = settings_.cache.denoised ? detail(texel, noise) : 1.0f;
    const float times = light > 0.0f ? factor * std::sqrt(noise.trimmed) / (kNoise * light) : 0.0f;
    return std::clamp(times, fewest, kMostTimes);
}

/// The noise estimate is a trimmed mean: where a few rays in a thousand hit a very bright source, more samples would
/// turn single bright texels, which the denoiser removes, into blotches.
SamplePlan::Noise SamplePlan::noiseAround(uint32_t texel, const TexelStates& states) const
{
    float squares = 0.0f;
    float freedom = 0.0f; // degrees of
    float mean = 0.0f;
    float inverseSquares = 0.0f;
    std::array<float, kAround> own;
    std::size_t count = 0;
    int texels = 0;
    grid_.around(texel, kRadius, [&](uint32_t other) {
        ++texels;
        const TexelState& state = states.of(other);
        if (!state.valid) return;
        const TexelEstimate& e = state.estimate;
        own[count] = std::max(e.gathered.squares, 0.0f) + std::max(e.emitted.squares, 0.0f);
        squares += own[count++];
        freedom += float(e.gathered.count - 1);
        mean += luminance(e.irradiance());
        inverseSquares += e.meanInverseSquare();
    });
    if (count == 0) return {.texels = texels};
    const std::size_t most = count - count / 5;
    if (most < count) std::nth_element(own.begin(), own.begin() + most, own.begin() + count);
    const float trimmed = std::accumulate(own.begin(), own.begin() + most, 0.0f) / float(most);
    return {squares / freedom, trimmed * float(count) / freedom, mean / float(count), texels,
            inverseSquares / float(count)};
}

float SamplePlan::detail(uint32_t texel, const Noise& noise) const
{
    const uint32_t triangle = map_.fragments[map_.texels[texel].firstFragment].triangle;
    const float width = geometry_.texelMeters(triangle);
    return kDetail * math::cbrt(width * std::sqrt(noise.meanInverseSquare));
}

/// Blocks after which the standard error of a texel's luminance is within the target. The target is relative to the
/// light, but at least to 2 % of the map's mean.
int SamplePlan::blocksForTarget(uint32_t texel, const TexelStates& states) const
{
    const Noise noise = noiseAround(texel, states);
    const float dark = 0.02f * mapMean_;
    const float allowed = settings_.cache.noiseTarget * std::max(noise.mean, dark);
    if (!(noise.variance > 0.0f)) return 0;
    if (!(allowed > 0.0f)) return mostBlocks();
    return int(std::ceil(std::min(noise.variance / (2.0f * allowed * allowed), blocks_)));
}

} // namespace halflight
