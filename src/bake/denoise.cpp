// The edge-avoiding à-trous wavelet filter (Dammertz et al. 2010, "Edge-Avoiding À-Trous Wavelet Transform for fast
// Global Illumination Filtering"). Its luminance edge-stopping function is scaled by the estimates' standard deviation
// (Schied et al. 2017, "Spatiotemporal Variance-Guided Filtering"): differences within the noise are smoothed, larger
// ones (contact shadows) stay. Its neighbourhoods go on across seams, so that both sides average the same texels.
//
// The first level averages traced texels alone. Each level fits a polynomial of second order first and averages the
// residuals (Savitzky and Golay 1964; cf. Bitterli et al. 2016, "Nonlinearly Weighted First-order Regression for
// Denoising Monte Carlo Renderings"). Without it a gradient would be smoothed only along its isolines. Beside edges of
// light and at rims, slopes take the polynomial's place, from the second level on.
#include "bake/denoise.h"

#include "bake/refinements.h"
#include "bake/stages.h"

#include "halflight/base/memory.h"
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
    const SurfaceGrid& grid;
    const std::vector<Guide>& guides;
    const Signals& in;
    int number = 0; ///< taps are 2^number texels apart
    bool directions = false;

    [[nodiscard]] int step() const { return 1 << number; }
    /// Whether a texel counts for gathered light.
    [[nodiscard]] bool counts(uint32_t texel) const
    {
        return guides[texel].valid && (number > 0 || guides[texel].traced);
    }
};

/// What the filter reads at one tap: the values of a texel, or beyond a seam the bilinear mean of those around a place.
struct Tap {
    bool valid = false;  ///< on the surface, and outside geometry
    bool counts = false; ///< for gathered light
    vec3 position{0.0f};
    vec3 normal{0.0f}; ///< unit
    NoisyLight gathered;
    NoisyLight direct;
    vec3 moment{0.0f};
};
using Taps = std::array<Tap, kTaps>; ///< row by row

constexpr std::array<float, kTaps> weightsOfTaps()
{
    std::array<float, kTaps> weights{};
    for (int k = 0; k < kTaps; ++k) {
        const int dx = k % 5 < 2 ? 2 - k % 5 : k % 5 - 2;
        const int dy = k / 5 < 2 ? 2 - k / 5 : k / 5 - 2;
        weights[std::size_t(k)] = kSpline[std::size_t(dx)] * kSpline[std::size_t(dy)];
    }
    return weights;
}
constexpr std::array<float, kTaps> kTapWeights = weightsOfTaps();

/// Squared difference of luminance over the noise that is expected, the exponent of a weight exp(-x). Differences below
/// `tolerance` (lux) count little too.
float luminanceDistance(const NoisyLight& a, const NoisyLight& b, float tolerance)
{
    constexpr float kSigmas = 2.0f; // standard deviations: 95 % of the noise
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

/// Whether two taps lie on one side of a surface, and not round a corner or a crease.
bool sameSide(const Tap& a, const Tap& b)
{
    return glm::dot(a.normal, b.normal) >= 0.9f;
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

Tap tapOn(const Level& level, uint32_t j)
{
    const Guide& guide = level.guides[j];
    Tap tap{guide.valid, level.counts(j), guide.place.position, guide.place.normal, level.in.gathered[j], {}, {}};
    if (!level.in.direct.empty()) tap.direct = level.in.direct[j];
    if (level.directions) tap.moment = level.in.moments[j];
    return tap;
}

/// Nearest texels would lie up to 0.7 texels off, towards the light on one side of a seam and away from it on the
/// other.
Tap tapBeyond(const Level& level, const SurfaceGrid::Footprint& footprint)
{
    constexpr float kEnough = 0.5f; // of a footprint's weight; with less, its mean is that of other places
    Tap sum;
    float weight = 0.0f;
    for (std::size_t n = 0; n < footprint.count; ++n) {
        if (level.counts(footprint.texels[n])) weight += footprint.weights[n];
    }
    if (weight < kEnough) return sum;
    for (std::size_t n = 0; n < footprint.count; ++n) {
        if (!level.counts(footprint.texels[n])) continue;
        const float w = footprint.weights[n] / weight;
        const float ofVariance = level.number == 0 ? w * w : w; // values of later levels share texels
        const Tap tap = tapOn(level, footprint.texels[n]);
        sum.position += w * tap.position;
        sum.normal += w * tap.normal;
        sum.gathered.irradiance += w * tap.gathered.irradiance;
        sum.gathered.variance += ofVariance * tap.gathered.variance;
        sum.direct.irradiance += w * tap.direct.irradiance;
        sum.direct.variance += ofVariance * tap.direct.variance;
        sum.moment += w * tap.moment;
    }
    sum.valid = sum.counts = glm::length(sum.normal) > 0.0f;
    if (sum.valid) sum.normal = glm::normalize(sum.normal);
    return sum;
}

Taps tapsOf(const Level& level, uint32_t i)
{
    Taps taps;
    for (int k = 0; k < kTaps; ++k) {
        const int dx = (k % 5 - 2) * level.step();
        const int dy = (k / 5 - 2) * level.step();
        const uint32_t j = level.grid.onChart(i, dx, dy);
        taps[std::size_t(k)] = j != kNoTexel ? tapOn(level, j) : tapBeyond(level, level.grid.beyond(i, dx, dy));
    }
    return taps;
}

/// How gathered light changes around a texel: a polynomial of the offset in taps, 0 at the texel.
struct Trend {
    vec3 x{0.0f}; ///< lux per tap
    vec3 y{0.0f};
    vec3 xx{0.0f}; ///< lux per squared tap
    vec3 xy{0.0f};
    vec3 yy{0.0f};
    float noise = 1.0f; ///< ratio of the variances of a mean less the trend and of a plain mean

    [[nodiscard]] vec3 at(int dx, int dy) const
    {
        return float(dx) * x + float(dy) * y + float(dx * dx) * xx + float(dx * dy) * xy + float(dy * dy) * yy;
    }
};

/// The polynomial of second order with the least squares over all 5 x 5 taps, whose terms have these sums of squares.
Trend fittedTrend(const Taps& taps)
{
    constexpr float kLinear = 50.0f;
    constexpr float kSquare = 70.0f; // of x^2 - 2
    constexpr float kMixed = 100.0f;
    Trend trend;
    for (int k = 0; k < kTaps; ++k) {
        const auto dx = float(k % 5 - 2);
        const auto dy = float(k / 5 - 2);
        const vec3 light = taps[std::size_t(k)].gathered.irradiance;
        trend.x += dx / kLinear * light;
        trend.y += dy / kLinear * light;
        trend.xx += (dx * dx - 2.0f) / kSquare * light;
        trend.xy += dx * dy / kMixed * light;
        trend.yy += (dy * dy - 2.0f) / kSquare * light;
    }
    trend.noise = 2.1f; // of the mean weighted by the spline: 0.165 instead of 0.079
    return trend;
}

/// Change of gathered light between two taps on opposite sides, lux per tap; 0 where one is missing.
vec3 slopeBetween(const Tap& behind, const Tap& own, const Tap& ahead)
{
    constexpr float kTapsBetween = 2.0f; // from each to the middle
    if (!behind.valid || !ahead.valid || !sameSide(behind, own) || !sameSide(ahead, own)) return vec3(0.0f);
    const vec3 light = own.gathered.irradiance;
    return minmod(ahead.gathered.irradiance - light, light - behind.gathered.irradiance) / kTapsBetween;
}

NoisyLight lessTrend(const Taps& taps, int tap, const Trend& trend)
{
    const NoisyLight& light = taps[std::size_t(tap)].gathered;
    return {light.irradiance - trend.at(tap % 5 - 2, tap / 5 - 2), light.variance};
}

/// By tap, the luminanceDistance() of gathered light, less a trend, from the middle's.
using Distances = std::array<float, kTaps>;

Distances distancesFrom(const Taps& taps, const Trend& trend)
{
    const Tap& own = taps[kMiddleTap];
    Distances distances;
    for (int k = 0; k < kTaps; ++k)
        distances[std::size_t(k)] = luminanceDistance(own.gathered, lessTrend(taps, k, trend), 0.0f);
    return distances;
}

/// Weight of the taps that differ from the middle by no more than noise, 0…1.
float explained(const Distances& distances)
{
    float sum = 0.0f;
    for (std::size_t k = 0; k < kTaps; ++k) sum += kTapWeights[k] * falloff(distances[k]);
    return sum;
}

/// A trend, and distances less it.
struct Detrended {
    Trend trend;
    Distances distances;
};

/// The fitted trend on smooth light, slopes beside edges of light, which no polynomial follows. Means less a fitted
/// trend have less bias, so that it may explain somewhat less.
Detrended detrendedOf(const Level& level, const Taps& taps)
{
    constexpr float kEnough = 0.75f; // of what slopes explain
    const Tap& own = taps[kMiddleTap];
    float fittedExplains = 0.0f;
    Detrended result;
    const auto fits = [&](const Tap& tap) { return tap.counts && sameSide(tap, own); };
    if (refinements.fittedTrend && std::all_of(taps.begin(), taps.end(), fits)) {
        result.trend = fittedTrend(taps);
        result.distances = distancesFrom(taps, result.trend);
        fittedExplains = explained(result.distances);
        if (fittedExplains >= kEnough) return result; // slopes explain 1 at most
    }
    Detrended slopes;
    if (level.number > 0 && refinements.slopes) { // single texels are too noisy
        slopes.trend.x = slopeBetween(taps[kMiddleTap - 2], own, taps[kMiddleTap + 2]);
        slopes.trend.y = slopeBetween(taps[kMiddleTap - 10], own, taps[kMiddleTap + 10]);
    }
    slopes.distances = distancesFrom(taps, slopes.trend);
    const bool fitted = fittedExplains > 0.0f && fittedExplains >= kEnough * explained(slopes.distances);
    return fitted ? result : slopes;
}

struct GeometricWeight {
    float near = 0.0f;           ///< spline × agreement of normals
    float planeDistance2 = 0.0f; ///< squared distance from the texel's plane, in taps
};

/// Of another tap's place; nothing where the weight is negligible. Texels that are adjacent on the map and far apart in
/// the world (folded charts) have none.
std::optional<GeometricWeight> geometricWeight(const Tap& own, const Tap& other, float spline, float planeScale)
{
    constexpr float kFarTaps = 8.0f; // taps; the corner of 5 x 5 is 2.8 away on a flat chart
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
    constexpr float kMomentTolerance = 0.2f; // of direct light: directions stop at its edges
    const Taps taps = tapsOf(level, i);
    const Tap& own = taps[kMiddleTap];
    const float planeScale = 1.0f / (float(level.step()) * level.guides[i].place.texelMeters);
    const bool hasDirect = !level.in.direct.empty();
    const bool noisyDirect = own.direct.variance > 0.0f && refinements.filteredDirect;
    const Detrended light = detrendedOf(level, taps);
    const float momentTolerance = kMomentTolerance * luminance(own.direct.irradiance);
    // At the rim of a chart, a tap without its mirror image would shift the mean: in a dark corner, towards the light.
    // Such taps are left out, unless the texel has no pair of taps at all.
    bool pairs = false;
    for (std::size_t k = 0; refinements.pairedTaps && k < kMiddleTap; ++k)
        pairs = pairs || (taps[k].counts && taps[kTaps - 1 - k].counts);
    Mean gathered;
    Mean direct;
    vec3 momentSum(0.0f);
    float momentWeight = 0.0f;
    for (int k = 0; k < kTaps; ++k) {
        const Tap& tap = taps[std::size_t(k)];
        const bool other = k != kMiddleTap;
        if (!tap.valid || (pairs && other && !taps[std::size_t(kTaps - 1 - k)].counts)) continue;
        GeometricWeight geometric = {kTapWeights[std::size_t(k)], 0.0f};
        float distance = 0.0f;
        if (other) {
            const auto found = geometricWeight(own, tap, geometric.near, planeScale);
            if (!found) continue;
            geometric = *found;
            distance = geometric.planeDistance2 + light.distances[std::size_t(k)];
        }
        if (noisyDirect) {
            const float directDistance = other ? luminanceDistance(own.direct, tap.direct, 0.0f) : 0.0f;
            direct.add(geometric.near * falloff(geometric.planeDistance2 + directDistance), tap.direct);
        }
        if (!tap.counts) continue;
        const float weight = geometric.near * falloff(distance);
        gathered.add(weight, lessTrend(taps, k, light.trend));
        if (!level.directions) continue;
        const float alike =
            hasDirect && other ? falloff(luminanceDistance(own.direct, tap.direct, momentTolerance)) : 1.0f;
        momentSum += weight * alike * tap.moment;
        momentWeight += weight * alike;
    }
    const float correlation = kCorrelation[std::size_t(level.number)];
    out.gathered[i] = gathered.light(own.gathered, correlation * light.trend.noise);
    if (level.directions) out.moments[i] = momentWeight > 0.0f ? momentSum / momentWeight : own.moment;
    if (hasDirect) out.direct[i] = direct.light(own.direct, correlation);
}

/// The estimates' signals, with variances corrected for stratification.
Signals signalsOf(const SurfaceGrid& grid, const std::vector<IrradianceEstimate>& estimates)
{
    Signals signals;
    const std::vector<float> scales = varianceScales(grid, estimates);
    const std::size_t count = estimates.size();
    signals.gathered = largeVector<NoisyLight>(count);
    signals.moments = largeVector<vec3>(count);
    forEachIndex(count, [&](std::size_t i) {
        signals.gathered[i] = gatheredOf(estimates[i]);
        signals.gathered[i].variance *= scales[i];
        signals.moments[i] = estimates[i].moment;
    });
    if (std::any_of(estimates.begin(), estimates.end(), [](const auto& e) { return e.direct != vec3(0.0f); })) {
        signals.direct = largeVector<NoisyLight>(count);
        forEachIndex(count, [&](std::size_t i) {
            signals.direct[i] = {estimates[i].direct, kDirectVarianceScale * estimates[i].varianceOfDirect};
        });
    }
    return signals;
}

} // namespace

void denoise(const BakeGeometry& geometry, const TexelMap& map, std::span<const SeamSample> seams,
             std::vector<IrradianceEstimate>& estimates, bool directions)
{
    const std::size_t count = map.texels.size();
    const SurfaceGrid grid(map, seams);
    Signals signals = signalsOf(grid, estimates);
    std::vector<Guide> guides = largeVector<Guide>(count);
    forEachIndex(count, [&](std::size_t i) {
        guides[i] = {placeOf(geometry, map, map.texels[i]), estimates[i].valid, isTraced(estimates[i])};
    });
    clampOutliers(map, grid, estimates, signals.gathered, signals.moments);

    Signals next;
    next.gathered = largeVector<NoisyLight>(count);
    next.direct = largeVector<NoisyLight>(signals.direct.size());
    next.moments = largeVector<vec3>(directions ? count : 0);
    for (int number = 0; number < int(kCorrelation.size()); ++number) {
        const Level level{grid, guides, signals, number, directions};
        forEachIndex(count, [&](std::size_t i) {
            if (guides[i].valid) filterTexel(level, uint32_t(i), next);
        });
        signals.gathered.swap(next.gathered);
        signals.direct.swap(next.direct);
        if (directions) signals.moments.swap(next.moments);
    }
    forEachIndex(count, [&](std::size_t i) {
        if (!estimates[i].valid) return;
        const NoisyLight direct = signals.direct.empty() ? NoisyLight{} : signals.direct[i];
        estimates[i].irradiance = signals.gathered[i].irradiance + direct.irradiance;
        estimates[i].direct = direct.irradiance;
        estimates[i].moment = signals.moments[i];
        estimates[i].varianceOfMean = signals.gathered[i].variance + direct.variance;
        estimates[i].varianceOfDirect = direct.variance;
    });
}

} // namespace halflight
