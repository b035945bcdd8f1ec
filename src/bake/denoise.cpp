// The edge-avoiding à-trous wavelet filter (Dammertz et al. 2010, "Edge-Avoiding À-Trous Wavelet Transform for fast
// Global Illumination Filtering"). Its luminance edge-stopping function is scaled by the estimates' standard deviation
// (Schied et al. 2017, "Spatiotemporal Variance-Guided Filtering"): differences within the noise are smoothed, larger
// ones (contact shadows) stay. Texels of other charts have no weight.
//
// The first level averages traced texels alone. From the second level on, the filter fits a slope first and averages
// the residuals (a first-order regression, cf. Bitterli et al. 2016, "Nonlinearly Weighted First-order Regression for
// Denoising Monte Carlo Renderings"). Without the slope a gradient would be smoothed only along its isolines.
#include "bake/denoise.h"

#include "bake/stages.h"

#include "halflight/base/parallel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace halflight {
namespace {

constexpr std::array<float, 3> kSpline = {3.0f / 8.0f, 1.0f / 4.0f, 1.0f / 16.0f}; ///< B3 spline, by distance
constexpr int kTaps = 25;                                                          ///< 5 × 5
constexpr int kMiddleTap = 12;
/// Ratio of the true variance of a weighted mean to that of independent values, by level. Values of level 2 and up
/// share texels. On an even surface k levels are a kernel of variance (4^k - 1) / 3 along each axis. These kernels
/// average 12.6, 63, 264 and 1070 texels. Independent values would multiply the number by 13.4 at each level.
constexpr std::array<float, 4> kCorrelation = {1.0f, 2.7f, 3.2f, 3.3f};
/// Direct light is stratified over texel and light; its stated variance is that of independent rays.
constexpr float kDirectVarianceScale = 0.1f;

/// What the filter smooths, by texel.
struct Signals {
    std::vector<NoisyLight> gathered;
    std::vector<NoisyLight> direct; ///< empty where no light is fully baked
    std::vector<vec3> moments;      ///< first moments of all light, lux
};

struct Guide {
    TexelPlace place;
    bool valid = false;
    bool traced = false;
};

/// One level of the filter: its inputs, all indexed by texel.
struct Level {
    const TexelMap& map;
    const TexelGrid& grid;
    const std::vector<Guide>& guides;
    const Signals& in;
    int number = 0; ///< taps are 2^number texels apart
    bool directions = false;

    [[nodiscard]] int step() const { return 1 << number; }
    /// Whether a tap counts for gathered light.
    [[nodiscard]] bool counts(uint32_t texel) const
    {
        return texel != kNoTexel && (number > 0 || guides[texel].traced);
    }
};

/// Texels at the taps of one texel, row by row; kNoTexel: none on the chart, or inside geometry.
using Taps = std::array<uint32_t, kTaps>;

/// Squared difference of luminance over the noise that is expected, the exponent of a weight exp(-x). Differences below
/// `tolerance` (lux) count little too.
float luminanceDistance(const NoisyLight& a, const NoisyLight& b, float tolerance)
{
    constexpr float kSigmas = 2.0f;
    const float difference = luminance(b.irradiance - a.irradiance);
    const float noise = 2.0f * kSigmas * kSigmas * std::min(a.variance, 4.0f * b.variance) + tolerance * tolerance;
    return difference * difference / (noise + 1.0e-12f);
}

float pow32(float x)
{
    for (int i = 0; i < 5; ++i) x *= x;
    return x;
}

/// exp(-x) approximated by (1 - x / 32)^32; 0 from x = 32 on.
float falloff(float x)
{
    return pow32(std::max(1.0f - x * (1.0f / 32.0f), 0.0f));
}

/// The smaller of two differences if they have one sign, else 0 (the minmod limiter, Roe 1986): the slope of a
/// gradient, and nearly nothing at edges, creases and in noise.
vec3 minmod(vec3 a, vec3 b)
{
    vec3 least(0.0f);
    for (int c = 0; c < 3; ++c) {
        if (a[c] * b[c] > 0.0f) least[c] = std::abs(a[c]) < std::abs(b[c]) ? a[c] : b[c];
    }
    return least;
}

/// Weighted mean, with its variance.
struct Mean {
    vec3 sum{0.0f};
    float weight = 0.0f;
    float variance = 0.0f;

    void add(float w, const NoisyLight& light)
    {
        sum += w * light.irradiance;
        weight += w;
        variance += w * w * light.variance;
    }
    /// `correlation`: kCorrelation of the level. The result is never noisier than the texel's `own` value.
    [[nodiscard]] NoisyLight light(const NoisyLight& own, float correlation) const
    {
        if (!(weight > 0.0f)) return own;
        return {sum / weight, std::min(correlation * variance / (weight * weight), own.variance)};
    }
};

/// Gradient of gathered light along (x, y), lux per tap; 0 where a neighbour is missing or lies on another side.
vec3 slopeAlong(const Level& level, uint32_t i, int x, int y)
{
    constexpr int kSpan = 2;
    constexpr float kSameSide = 0.9f; // cosine between normals
    if (level.number == 0) return vec3(0.0f);
    const int distance = kSpan * level.step();
    const uint32_t ahead = level.grid.at(level.map.texels[i], distance * x, distance * y);
    const uint32_t behind = level.grid.at(level.map.texels[i], -distance * x, -distance * y);
    for (const uint32_t j : {ahead, behind}) {
        if (j == kNoTexel || !level.guides[j].valid) return vec3(0.0f);
        if (glm::dot(level.guides[j].place.normal, level.guides[i].place.normal) < kSameSide) return vec3(0.0f);
    }
    const std::vector<NoisyLight>& light = level.in.gathered;
    const vec3 own = light[i].irradiance;
    return minmod(light[ahead].irradiance - own, own - light[behind].irradiance) / float(kSpan);
}

Taps tapsOf(const Level& level, uint32_t i)
{
    Taps taps;
    for (int k = 0; k < kTaps; ++k) {
        const uint32_t j = level.grid.at(level.map.texels[i], (k % 5 - 2) * level.step(), (k / 5 - 2) * level.step());
        taps[std::size_t(k)] = j != kNoTexel && level.guides[j].valid ? j : kNoTexel;
    }
    return taps;
}

struct GeometricWeight {
    float near = 0.0f;           ///< spline × agreement of normals
    float planeDistance2 = 0.0f; ///< squared distance from the texel's plane, in taps
};

/// Of another texel's place; nothing where the weight is negligible. Texels that are adjacent on the map and far apart
/// in the world (folded charts) have none.
std::optional<GeometricWeight> geometricWeight(const TexelPlace& own, const TexelPlace& other, float spline,
                                               float planeScale)
{
    constexpr float kFarTaps = 8.0f;
    constexpr float kNegligible = 1.0e-6f;
    const float cosine = std::max(glm::dot(own.normal, other.normal), 0.0f);
    const vec3 offset = other.position - own.position;
    const float plane = std::abs(glm::dot(offset, own.normal)) * planeScale;
    if (glm::dot(offset, offset) * planeScale * planeScale > kFarTaps * kFarTaps) return std::nullopt;
    const float near = spline * pow32(cosine);
    if (near < kNegligible) return std::nullopt;
    return GeometricWeight{near, plane * plane};
}

/// Filters one texel; writes its entry of `out`.
void filterTexel(const Level& level, uint32_t i, Signals& out)
{
    constexpr float kMomentTolerance =
        0.2f; // of direct light: directions of all light stop at the edges of direct light
    const Signals& in = level.in;
    const TexelPlace& place = level.guides[i].place;
    const float planeScale = 1.0f / (float(level.step()) * place.texelMeters);
    const bool hasDirect = !in.direct.empty();
    const bool noisyDirect = hasDirect && in.direct[i].variance > 0.0f;
    const vec3 slopeX = slopeAlong(level, i, 1, 0);
    const vec3 slopeY = slopeAlong(level, i, 0, 1);
    const float momentTolerance = hasDirect ? kMomentTolerance * luminance(in.direct[i].irradiance) : 0.0f;
    // At the rim of a chart, a tap without its mirror image would shift the mean: in a dark corner, towards the light.
    // Such taps are left out, unless the texel has no pair of taps at all.
    const Taps taps = tapsOf(level, i);
    bool pairs = false;
    for (std::size_t k = 0; k < kMiddleTap; ++k)
        pairs = pairs || (level.counts(taps[k]) && level.counts(taps[kTaps - 1 - k]));
    Mean gathered;
    Mean direct;
    vec3 momentSum(0.0f);
    float momentWeight = 0.0f;
    for (int k = 0; k < kTaps; ++k) {
        const uint32_t j = taps[std::size_t(k)];
        const bool other = j != i;
        if (j == kNoTexel || (pairs && other && !level.counts(taps[std::size_t(kTaps - 1 - k)]))) continue;
        const int dx = k % 5 - 2;
        const int dy = k / 5 - 2;
        GeometricWeight geometric = {kSpline[std::size_t(std::abs(dx))] * kSpline[std::size_t(std::abs(dy))], 0.0f};
        const NoisyLight levelled = {in.gathered[j].irradiance - float(dx) * slopeX - float(dy) * slopeY,
                                     in.gathered[j].variance};
        float distance = 0.0f;
        if (other) {
            const auto found = geometricWeight(place, level.guides[j].place, geometric.near, planeScale);
            if (!found) continue;
            geometric = *found;
            distance = geometric.planeDistance2 + luminanceDistance(in.gathered[i], levelled, 0.0f);
        }
        if (noisyDirect) {
            const float directDistance = other ? luminanceDistance(in.direct[i], in.direct[j], 0.0f) : 0.0f;
            direct.add(geometric.near * falloff(geometric.planeDistance2 + directDistance), in.direct[j]);
        }
        if (level.number == 0 && !level.guides[j].traced) continue;
        const float weight = geometric.near * falloff(distance);
        gathered.add(weight, levelled);
        if (!level.directions) continue;
        const float alike =
            hasDirect && other ? falloff(luminanceDistance(in.direct[i], in.direct[j], momentTolerance)) : 1.0f;
        momentSum += weight * alike * in.moments[j];
        momentWeight += weight * alike;
    }
    const float correlation = kCorrelation[std::size_t(level.number)];
    out.gathered[i] = gathered.light(in.gathered[i], correlation);
    if (level.directions) out.moments[i] = momentWeight > 0.0f ? momentSum / momentWeight : in.moments[i];
    if (hasDirect) out.direct[i] = direct.light(in.direct[i], correlation);
}

/// The estimates' signals, with variances corrected for stratification.
Signals signalsOf(const TexelMap& map, const TexelGrid& grid, const std::vector<IrradianceEstimate>& estimates)
{
    Signals signals;
    const std::vector<float> scales = varianceScales(map, grid, estimates);
    signals.gathered.resize(estimates.size());
    signals.moments.resize(estimates.size());
    for (std::size_t i = 0; i < estimates.size(); ++i) {
        signals.gathered[i] = gatheredOf(estimates[i]);
        signals.gathered[i].variance *= scales[i];
        signals.moments[i] = estimates[i].moment;
    }
    if (std::any_of(estimates.begin(), estimates.end(), [](const auto& e) { return e.direct != vec3(0.0f); })) {
        signals.direct.reserve(estimates.size());
        for (const IrradianceEstimate& e : estimates)
            signals.direct.push_back({e.direct, kDirectVarianceScale * e.varianceOfDirect});
    }
    return signals;
}

} // namespace

void denoise(const BakeGeometry& geometry, const TexelMap& map, std::vector<IrradianceEstimate>& estimates,
             bool directions)
{
    const std::size_t count = map.texels.size();
    const TexelGrid grid(map);
    Signals signals = signalsOf(map, grid, estimates);
    std::vector<Guide> guides(count);
    parallelFor(count, 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            guides[i] = {placeOf(geometry, map, map.texels[i]), estimates[i].valid, isTraced(estimates[i])};
    });
    clampOutliers(map, grid, estimates, signals.gathered, signals.moments);

    Signals next;
    next.gathered.resize(count);
    next.direct.resize(signals.direct.size());
    next.moments.resize(directions ? count : 0);
    for (int number = 0; number < int(kCorrelation.size()); ++number) {
        const Level level{map, grid, guides, signals, number, directions};
        parallelFor(count, 2048, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                if (guides[i].valid) filterTexel(level, uint32_t(i), next);
            }
        });
        signals.gathered.swap(next.gathered);
        signals.direct.swap(next.direct);
        if (directions) signals.moments.swap(next.moments);
    }
    for (std::size_t i = 0; i < count; ++i) {
        if (!estimates[i].valid) continue;
        const NoisyLight direct = signals.direct.empty() ? NoisyLight{} : signals.direct[i];
        estimates[i].irradiance = signals.gathered[i].irradiance + direct.irradiance;
        estimates[i].direct = direct.irradiance;
        estimates[i].moment = signals.moments[i];
        estimates[i].varianceOfMean = signals.gathered[i].variance + direct.variance;
        estimates[i].varianceOfDirect = direct.variance;
    }
}

} // namespace halflight
