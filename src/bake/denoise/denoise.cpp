// The edge-avoiding à-trous wavelet filter (Dammertz et al. 2010, "Edge-Avoiding À-Trous Wavelet Transform for fast
// Global Illumination Filtering"). Its luminance edge-stopping function is scaled by the estimates' standard deviation
// (Schied et al. 2017, "Spatiotemporal Variance-Guided Filtering"): differences within the noise are smoothed, larger
// ones (contact shadows) stay. Its neighbourhoods go on across seams, so that both sides average the same texels.
//
// The first level averages traced texels alone. Each level fits a polynomial of second order first and averages the
// residuals (Savitzky and Golay 1964; cf. Bitterli et al. 2016, "Nonlinearly Weighted First-order Regression for
// Denoising Monte Carlo Renderings"). Without it a gradient would be smoothed only along its isolines. Beside edges of
// light and at rims, slopes take the polynomial's place, from the second level on.
#include "bake/denoise/denoise.h"

#include "bake/denoise/denoise_taps.h"
#include "bake/geometry/smooth_normals.h"
#include "bake/seams/seams.h"
#include "bake/texels/texel_places.h"

#include "halflight/base/memory.h"
#include "halflight/base/parallel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace halflight {
namespace {

/// Ratio of the true variance of a weighted mean to that of independent values, by level. Values of level 2 and up
/// share texels. On an even surface k levels are a kernel of variance (4^k - 1) / 3 along each axis. These kernels
/// average 12.6, 63, 264 and 1070 texels. Independent values would multiply the number by 13.4 at each level.
constexpr std::array<float, 4> kCorrelation = {1.0f, 2.7f, 3.2f, 3.3f};
/// Direct light is stratified over texel and light; its stated variance is that of independent rays.
constexpr float kDirectVarianceScale = 0.1f;

constexpr std::array<float, 3> kSpline = {3.0f / 8.0f, 1.0f / 4.0f, 1.0f / 16.0f}; ///< B3 spline, by distance

/// Terms of a polynomial of second order at each tap, and the spline's weights; 0 beyond the taps.
struct TapTerms {
    TapFloats x{};
    TapFloats y{};
    TapFloats xx{};
    TapFloats xy{};
    TapFloats yy{};
    TapFloats spline{};
};
constexpr TapTerms makeTerms()
{
    TapTerms terms;
    for (int k = 0; k < kTaps; ++k) {
        const auto i = std::size_t(k);
        terms.x[i] = float(tapX(k));
        terms.y[i] = float(tapY(k));
        terms.xx[i] = terms.x[i] * terms.x[i];
        terms.xy[i] = terms.x[i] * terms.y[i];
        terms.yy[i] = terms.y[i] * terms.y[i];
        terms.spline[i] = kSpline[std::size_t(tapX(k) < 0 ? -tapX(k) : tapX(k))] *
                          kSpline[std::size_t(tapY(k) < 0 ? -tapY(k) : tapY(k))];
    }
    return terms;
}
constexpr TapTerms kTerms = makeTerms(); ///< of offsets in taps

/// A float of each tap from the tap's index. Loops of this form are vectorized.
template<typename Body> TapFloats forTaps(const Body& body)
{
    TapFloats out;
    for (std::size_t k = 0; k < kPaddedTaps; ++k) out[k] = body(k);
    return out;
}

/// Sum of products, in four parts side by side.
float dot(const TapFloats& a, const TapFloats& b)
{
    std::array<float, 4> parts{};
    for (std::size_t k = 0; k < kPaddedTaps; k += 4)
        for (std::size_t i = 0; i < 4; ++i) parts[i] += a[k + i] * b[k + i];
    return (parts[0] + parts[2]) + (parts[1] + parts[3]);
}
float sum(const TapFloats& values)
{
    return std::accumulate(values.begin(), values.end(), 0.0f);
}
vec3 dot(const TapFloats& weights, const TapColors& colors)
{
    return {dot(weights, colors.r), dot(weights, colors.g), dot(weights, colors.b)};
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

/// How gathered light changes around a texel: a polynomial of the offset in taps, 0 at the texel.
struct Trend {
    vec3 x{0.0f}; ///< lux per tap
    vec3 y{0.0f};
    vec3 xx{0.0f}; ///< lux per squared tap
    vec3 xy{0.0f};
    vec3 yy{0.0f};
    float noise = 1.0f; ///< ratio of the variances of a mean less the trend and of a plain mean

    /// Sum of the trend at all taps.
    [[nodiscard]] vec3 sum(const TapFloats& weights) const
    {
        return dot(weights, kTerms.x) * x + dot(weights, kTerms.y) * y + dot(weights, kTerms.xx) * xx +
               dot(weights, kTerms.xy) * xy + dot(weights, kTerms.yy) * yy;
    }
};

/// By tap, the squared difference of luminance from the middle tap's over the noise that is expected, the exponent of a
/// weight exp(-x). `trend`: taken from the taps. Differences below `tolerance` (lux) count little too.
TapFloats distances(const TapLights& light, const Trend& trend, float tolerance)
{
    constexpr float kSigmas = 2.0f; // standard deviations: 95 % of the noise
    const float own = light.luminance[kMiddleTap];
    const float ownVariance = light.variance[kMiddleTap];
    const float least = tolerance * tolerance + 1.0e-12f;
    const float x = luminance(trend.x);
    const float y = luminance(trend.y);
    const float xx = luminance(trend.xx);
    const float xy = luminance(trend.xy);
    const float yy = luminance(trend.yy);
    return forTaps([&](std::size_t k) {
        const float change =
            kTerms.x[k] * x + kTerms.y[k] * y + kTerms.xx[k] * xx + kTerms.xy[k] * xy + kTerms.yy[k] * yy;
        const float difference = light.luminance[k] - own - change;
        const float noise = 2.0f * kSigmas * kSigmas * std::min(ownVariance, 4.0f * light.variance[k]) + least;
        return difference * difference / noise;
    });
}

/// The polynomial of second order with the least squares over all 5 x 5 taps, whose terms have these sums of squares.
Trend fittedTrend(const TapColors& light)
{
    constexpr float kLinear = 50.0f;
    constexpr float kSquare = 70.0f; // of x^2 - 2
    constexpr float kMixed = 100.0f;
    const vec3 twice = 2.0f * vec3(sum(light.r), sum(light.g), sum(light.b));
    Trend trend;
    trend.x = dot(kTerms.x, light) / kLinear;
    trend.y = dot(kTerms.y, light) / kLinear;
    trend.xx = (dot(kTerms.xx, light) - twice) / kSquare;
    trend.xy = dot(kTerms.xy, light) / kMixed;
    trend.yy = (dot(kTerms.yy, light) - twice) / kSquare;
    trend.noise = 2.1f; // of the mean weighted by the spline: 0.165 instead of 0.079
    return trend;
}

/// A texel's taps, and what the weights of several of the filter's means share.
struct Neighbourhood {
    const Level& level;
    const Taps& taps;
    TapFloats cosine; ///< of the angle between a tap's normal and the middle's, 0…1

    Neighbourhood(const Level& levelOf, const Taps& tapsOf) : level(levelOf), taps(tapsOf)
    {
        const vec3 own = taps.normal.at(kMiddleTap);
        cosine = forTaps([&](std::size_t k) {
            return std::max(own.x * taps.normal.r[k] + own.y * taps.normal.g[k] + own.z * taps.normal.b[k], 0.0f);
        });
    }

    /// Whether a tap lies on the middle's side of a surface, and not round a corner or a crease.
    [[nodiscard]] bool sameSide(std::size_t tap) const { return cosine[tap] >= kSmoothCosine; }

    /// Change of gathered light between two taps on opposite sides, lux per tap; 0 where one is missing.
    [[nodiscard]] vec3 slopeBetween(std::size_t behind, std::size_t ahead) const
    {
        constexpr float kTapsBetween = 2.0f; // from each to the middle
        if (!sameSide(behind) || !sameSide(ahead)) return vec3(0.0f);
        const TapColors& light = taps.gathered.irradiance;
        const vec3 own = light.at(kMiddleTap);
        return minmod(light.at(ahead) - own, own - light.at(behind)) / kTapsBetween;
    }

    /// Spline × agreement of normals. Texels that are adjacent on the map and far apart in the world (folded charts)
    /// have none. At the rim of a chart, a tap without its mirror image would shift the mean: in a dark corner, towards
    /// the light. Such taps are left out, unless the texel has no pair of taps at all.
    [[nodiscard]] TapFloats nearness(float tapsPerMeter) const
    {
        constexpr float kFarTaps = 8.0f; // taps; the corner of 5 x 5 is 2.8 away on a flat chart
        constexpr float kFar2 = kFarTaps * kFarTaps;
        const auto mirrored = [&](std::size_t k) { return k < kTaps ? taps.counts[kTaps - 1 - k] : 0.0f; };
        bool pairs = false;
        for (std::size_t k = 0; k < kMiddleTap; ++k) pairs = pairs || taps.counts[k] * mirrored(k) > 0.0f;
        TapFloats near = forTaps([&](std::size_t k) {
            const float offset2 = taps.position.r[k] * taps.position.r[k] + taps.position.g[k] * taps.position.g[k] +
                                  taps.position.b[k] * taps.position.b[k];
            const float within = offset2 * tapsPerMeter * tapsPerMeter > kFar2 ? 0.0f : taps.valid[k];
            return within * kTerms.spline[k] * pow32(cosine[k]);
        });
        for (std::size_t k = 0; pairs && k < kTaps; ++k)
            if (k != kMiddleTap && mirrored(k) == 0.0f) near[k] = 0.0f;
        return near;
    }

    /// Squared distance from the middle's plane, in taps.
    [[nodiscard]] TapFloats planeDistances2(float tapsPerMeter) const
    {
        const vec3 own = taps.normal.at(kMiddleTap) * tapsPerMeter;
        return forTaps([&](std::size_t k) {
            const float distance = own.x * taps.position.r[k] + own.y * taps.position.g[k] + own.z * taps.position.b[k];
            return distance * distance;
        });
    }
};

/// A trend, and distances() less it.
struct Detrended {
    Trend trend;
    TapFloats distances;

    Detrended(const TapLights& light, const Trend& trendOf)
        : trend(trendOf), distances(halflight::distances(light, trendOf, 0.0f))
    {}
    /// Weight of the taps that differ from the middle by no more than noise, 0…1.
    [[nodiscard]] float explained() const
    {
        return dot(kTerms.spline, forTaps([&](std::size_t k) { return falloff(distances[k]); }));
    }
};

/// The fitted trend on smooth light, slopes beside edges of light, which no polynomial follows. Means less a fitted
/// trend have less bias, so that it may explain somewhat less.
Detrended detrendedOf(const Neighbourhood& around)
{
    constexpr float kEnough = 0.75f; // of what slopes explain
    const TapLights& light = around.taps.gathered;
    Trend slopes;
    if (around.level.number > 0) { // single texels are too noisy
        slopes.x = around.slopeBetween(kMiddleTap - 2, kMiddleTap + 2);
        slopes.y = around.slopeBetween(kMiddleTap - 10, kMiddleTap + 10);
    }
    bool fits = true;
    for (std::size_t k = 0; fits && k < kTaps; ++k) fits = around.taps.counts[k] > 0.0f && around.sameSide(k);
    if (!fits) return {light, slopes};
    const Detrended fitted(light, fittedTrend(light.irradiance));
    const float explained = fitted.explained();
    if (explained >= kEnough) return fitted; // slopes explain 1 at most
    const Detrended sloped(light, slopes);
    return explained >= kEnough * sloped.explained() ? fitted : sloped;
}

/// A weighted mean, and its variance: that of independent values times `correlation`. It is never noisier than the
/// middle tap.
NoisyLight meanOf(const TapLights& light, const TapFloats& weights, const Trend& trend, float correlation)
{
    const float weight = sum(weights);
    const NoisyLight own{light.irradiance.at(kMiddleTap), light.variance[kMiddleTap]};
    if (!(weight > 0.0f)) return own;
    const TapFloats squares = forTaps([&](std::size_t k) { return weights[k] * weights[k]; });
    const float variance = dot(squares, light.variance);
    return {(dot(weights, light.irradiance) - trend.sum(weights)) / weight,
            std::min(correlation * variance / (weight * weight), own.variance)};
}

/// Filters one texel; writes its entry of `out`.
void filterTexel(const Level& level, uint32_t i, Signals& out)
{
    constexpr float kMomentTolerance = 0.2f; // of direct light: directions stop at its edges
    const Taps taps(level, i);
    const Neighbourhood around(level, taps);
    const float tapsPerMeter = 1.0f / (float(level.step()) * level.guides[i].place.texelMeters);
    const float correlation = kCorrelation[std::size_t(level.number)];
    const TapFloats near = around.nearness(tapsPerMeter);
    const TapFloats plane2 = around.planeDistances2(tapsPerMeter);
    const Detrended gathered = detrendedOf(around);
    const TapFloats weights =
        forTaps([&](std::size_t k) { return taps.counts[k] * near[k] * falloff(plane2[k] + gathered.distances[k]); });
    out.gathered[i] = meanOf(taps.gathered, weights, gathered.trend, correlation * gathered.trend.noise);
    const bool hasDirect = !level.in.direct.empty();
    if (hasDirect) {
        out.direct[i] = {taps.direct.irradiance.at(kMiddleTap), taps.direct.variance[kMiddleTap]};
        if (out.direct[i].variance > 0.0f) {
            const TapFloats distance = distances(taps.direct, {}, 0.0f);
            const TapFloats ofDirect =
                forTaps([&](std::size_t k) { return near[k] * falloff(plane2[k] + distance[k]); });
            out.direct[i] = meanOf(taps.direct, ofDirect, {}, correlation);
        }
    }
    if (!level.directions) return;
    TapFloats ofMoments = weights;
    if (hasDirect) {
        const float tolerance = kMomentTolerance * taps.direct.luminance[kMiddleTap];
        const TapFloats distance = distances(taps.direct, {}, tolerance);
        ofMoments = forTaps([&](std::size_t k) { return weights[k] * falloff(distance[k]); });
    }
    const float weight = sum(ofMoments);
    out.moments[i] = weight > 0.0f ? dot(ofMoments, taps.moment) / weight : taps.moment.at(kMiddleTap);
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
