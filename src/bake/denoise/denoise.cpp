// The edge-avoiding à-trous wavelet filter (Dammertz et al. 2010, "Edge-Avoiding À-Trous Wavelet Transform for fast
// Global Illumination Filtering"). Its luminance edge-stopping function is scaled by the estimates' standard deviation
// (Schied et al. 2017, "Spatiotemporal Variance-Guided Filtering"): differences within the noise are smoothed, larger
// ones (contact shadows) stay. Its neighbourhoods go on across seams, so that both sides average the same texels.
//
// Each level fits a polynomial of second order first and averages the
// residuals (Savitzky and Golay 1964; cf. Bitterli et al. 2016, "Nonlinearly Weighted First-order Regression for
// Denoising Monte Carlo Renderings"). Without it a gradient would be smoothed only along its isolines. Beside edges of
// light and at rims, slopes take the polynomial's place, from the second level on.
#include "bake/denoise/denoise.h"

#include "bake/denoise/denoise_outliers.h"
#include "bake/denoise/denoise_taps.h"
#include "bake/geometry/smooth_normals.h"
#include "bake/seams/seams.h"
#include "bake/texels/texel_places.h"

#include "halflight/base/memory.h"
#include "halflight/base/parallel.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <numeric>

namespace halflight {
namespace {

using shading::Trend;

static_assert(shading::kSameSideOfTaps == kSmoothCosine);

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
        terms.spline[i] = shading::tapSpline(k);
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

vec3 sum(const TapColors& colors)
{
    return {sum(colors.r), sum(colors.g), sum(colors.b)};
}

/// tapDistance() of all taps, less a trend that was taken from them.
TapFloats distances(const TapLights& light, const Trend& trend, float tolerance)
{
    const shading::TapComparison to =
        shading::tapComparison(light.luminance[kMiddleTap], light.variance[kMiddleTap], trend, tolerance);
    return forTaps([&](std::size_t k) {
        return shading::tapDistance(to, light.luminance[k], light.variance[k], kTerms.x[k], kTerms.y[k], kTerms.xx[k],
                                    kTerms.xy[k], kTerms.yy[k]);
    });
}

Trend fittedTrend(const TapColors& light)
{
    return shading::fittedTrend({sum(light), dot(kTerms.x, light), dot(kTerms.y, light), dot(kTerms.xx, light),
                                 dot(kTerms.xy, light), dot(kTerms.yy, light)});
}

/// A texel's taps, and what the weights of all of the filter's means share.
struct Neighbourhood {
    const Level& level;
    const Taps& taps;
    TapFloats cosine; ///< of the angle between a tap's normal and the middle's, 0…1
    TapFloats near;   ///< tapNearness()
    TapFloats plane2; ///< squared distance from the middle's plane, in taps
    bool even = true; ///< all taps are there, on the middle's side

    Neighbourhood(const Level& levelOf, const Taps& tapsOf, float tapsPerMeter) : level(levelOf), taps(tapsOf)
    {
        const vec3 own = taps.normal.at(kMiddleTap);
        cosine = forTaps([&](std::size_t k) {
            return std::max(own.x * taps.normal.r[k] + own.y * taps.normal.g[k] + own.z * taps.normal.b[k], 0.0f);
        });
        near = nearness(tapsPerMeter);
        plane2 = planeDistances2(tapsPerMeter);
        for (std::size_t k = 0; even && k < kTaps; ++k) even = taps.valid[k] > 0.0f && sameSide(k);
    }

    /// Whether a tap lies on the middle's side of a surface, and not round a corner or a crease.
    [[nodiscard]] bool sameSide(std::size_t tap) const { return cosine[tap] >= shading::kSameSideOfTaps; }

    /// Change of gathered light between two taps on opposite sides, lux per tap; 0 where one is missing.
    [[nodiscard]] vec3 slopeBetween(const TapColors& light, std::size_t behind, std::size_t ahead) const
    {
        if (!sameSide(behind) || !sameSide(ahead)) return vec3(0.0f);
        return shading::slopeOfTaps(light.at(behind), light.at(kMiddleTap), light.at(ahead));
    }

private:
    /// tapNearness() of all taps. At the rim of a chart, a tap without its mirror image would shift the mean: in a dark
    /// corner, towards the light. Such taps are left out, unless the texel has no pair of taps at all.
    [[nodiscard]] TapFloats nearness(float tapsPerMeter) const
    {
        const auto mirrored = [&](std::size_t k) { return k < kTaps ? taps.valid[kTaps - 1 - k] : 0.0f; };
        bool pairs = false;
        for (std::size_t k = 0; k < kMiddleTap; ++k) pairs = pairs || taps.valid[k] * mirrored(k) > 0.0f;
        TapFloats near = forTaps([&](std::size_t k) {
            return shading::tapNearness(taps.position.at(k), cosine[k], kTerms.spline[k], taps.valid[k], tapsPerMeter);
        });
        for (std::size_t k = 0; pairs && k < kTaps; ++k)
            if (k != kMiddleTap && mirrored(k) == 0.0f) near[k] = 0.0f;
        return near;
    }

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
        return dot(kTerms.spline, forTaps([&](std::size_t k) { return shading::falloff(distances[k]); }));
    }
};

/// The fitted trend on smooth light, slopes beside edges of light, which no polynomial follows.
Detrended detrendedOf(const Neighbourhood& around, const TapLights& light)
{
    Trend slopes = shading::flatTrend();
    if (around.level.number > 0) { // single texels are too noisy
        slopes.x = around.slopeBetween(light.irradiance, kMiddleTap - 2, kMiddleTap + 2);
        slopes.y = around.slopeBetween(light.irradiance, kMiddleTap - 10, kMiddleTap + 10);
    }
    if (!around.even) return {light, slopes};
    const Detrended fitted(light, fittedTrend(light.irradiance));
    const float explained = fitted.explained();
    if (explained >= shading::kEnoughExplained) return fitted; // slopes explain 1 at most
    const Detrended sloped(light, slopes);
    return explained >= shading::kEnoughExplained * sloped.explained() ? fitted : sloped;
}

NoisyLight meanOf(const TapLights& light, const TapFloats& weights, const Trend& trend, float correlation)
{
    const TapFloats squares = forTaps([&](std::size_t k) { return weights[k] * weights[k]; });
    const shading::TermSums terms{dot(weights, kTerms.x), dot(weights, kTerms.y), dot(weights, kTerms.xx),
                                  dot(weights, kTerms.xy), dot(weights, kTerms.yy)};
    return shading::meanOfTaps(light.middle(), sum(weights), dot(squares, light.variance),
                               dot(weights, light.irradiance) - shading::sumOfTrend(trend, terms), correlation);
}

/// Filters the light of one texel; writes its entry of `out`.
void filterLight(const Neighbourhood& around, const Signals& in, uint32_t i, Signals& out)
{
    const LightTaps taps({in, around.level.number}, around.taps);
    const float correlation = shading::correlationOf(around.level.number);
    const Trend flat = shading::flatTrend();
    const TapFloats& near = around.near;
    const TapFloats& plane2 = around.plane2;
    const Detrended gathered = detrendedOf(around, taps.gathered);
    const TapFloats weights =
        forTaps([&](std::size_t k) { return near[k] * shading::falloff(plane2[k] + gathered.distances[k]); });
    out.gathered[i] = meanOf(taps.gathered, weights, gathered.trend, correlation * gathered.trend.noise);
    const bool hasDirect = !in.direct.empty();
    if (hasDirect) {
        out.direct[i] = taps.direct.middle();
        if (out.direct[i].variance > 0.0f) {
            const TapFloats distance = distances(taps.direct, flat, 0.0f);
            const TapFloats ofDirect =
                forTaps([&](std::size_t k) { return near[k] * shading::falloff(plane2[k] + distance[k]); });
            out.direct[i] = meanOf(taps.direct, ofDirect, flat, correlation);
        }
    }
    if (in.moments.empty()) return;
    TapFloats ofMoments = weights;
    if (hasDirect) {
        const float tolerance = shading::kMomentTolerance * taps.direct.luminance[kMiddleTap];
        const TapFloats distance = distances(taps.direct, flat, tolerance);
        ofMoments = forTaps([&](std::size_t k) { return weights[k] * shading::falloff(distance[k]); });
    }
    const float weight = sum(ofMoments);
    out.moments[i] = weight > shading::kLeastWeight ? dot(ofMoments, taps.moment) / weight : taps.moment.at(kMiddleTap);
}

/// Filters one texel of all components.
void filterTexel(const Level& level, uint32_t i, std::span<const Signals> in, std::span<Signals> out)
{
    const Taps taps(level, i);
    const float tapsPerMeter = 1.0f / (float(level.step()) * level.guides[i].place.texelMeters);
    const Neighbourhood around(level, taps, tapsPerMeter);
    for (std::size_t c = 0; c < in.size(); ++c) filterLight(around, in[c], i, out[c]);
}

std::vector<DenoiseGuide> guidesOf(const DenoiserTexels& texels)
{
    std::vector<DenoiseGuide> guides = largeVector<DenoiseGuide>(texels.valid.size());
    forEachIndex(guides.size(), [&](std::size_t i) {
        guides[i] = {placeOf(texels.geometry, texels.map, texels.map.texels[i]), texels.valid[i] != 0};
    });
    return guides;
}

/// Whether wanted() holds for any estimate.
template<typename Wanted> bool anyOf(std::span<const IrradianceEstimate> estimates, const Wanted& wanted)
{
    std::atomic<bool> found = false;
    parallelFor(estimates.size(), 65536, [&](std::size_t begin, std::size_t end) {
        if (!found && std::ranges::any_of(estimates.subspan(begin, end - begin), wanted)) found = true;
    });
    return found;
}

void writeTo(std::vector<IrradianceEstimate>& estimates, const Signals& signals)
{
    forEachIndex(estimates.size(), [&](std::size_t i) {
        if (!estimates[i].valid) return;
        const NoisyLight direct = signals.direct.empty() ? NoisyLight{} : signals.direct[i];
        estimates[i].irradiance = signals.gathered[i].irradiance + direct.irradiance;
        estimates[i].direct = direct.irradiance;
        if (!signals.moments.empty()) estimates[i].moment = signals.moments[i];
        estimates[i].varianceOfMean = signals.gathered[i].variance + direct.variance;
        estimates[i].varianceOfDirect = direct.variance;
    });
}

} // namespace

void denoiseComponents(const DenoiserTexels& texels, std::span<Signals> components)
{
    clampSignals(texels, components);
    const std::vector<DenoiseGuide> guides = guidesOf(texels);
    std::vector<Signals> next(components.size());
    for (std::size_t c = 0; c < next.size(); ++c) {
        next[c].gathered = largeVector<NoisyLight>(guides.size());
        next[c].direct = largeVector<NoisyLight>(components[c].direct.size());
        next[c].moments = largeVector<vec3>(components[c].moments.size());
    }
    for (int number = 0; number < shading::kFilterLevels; ++number) {
        const Level level{texels.grid, guides, number};
        forEachIndex(guides.size(), [&](std::size_t i) {
            if (guides[i].valid) filterTexel(level, uint32_t(i), components, next);
        });
        std::swap_ranges(components.begin(), components.end(), next.begin());
    }
}

Status denoiseComponents(const DenoiserTexels& texels, std::span<Signals> components, const DeviceDenoiser& device)
{
    if (!device) {
        denoiseComponents(texels, components);
        return {};
    }
    Status status = device(texels, components);
    if (!status && status.error().code == ErrorCode::Unsupported) denoiseComponents(texels, components);
    return status;
}

Status denoise(const BakeGeometry& geometry, const TexelMap& map, std::span<const SeamSample> seams,
               std::vector<IrradianceEstimate>& estimates, bool directions, const DeviceDenoiser& device)
{
    const SurfaceGrid grid(map, seams);
    const bool hasDirect = anyOf(estimates, [](const auto& e) { return e.direct != vec3(0.0f); });
    const std::size_t count = estimates.size();
    std::vector<uint8_t> valid = largeVector<uint8_t>(count);
    std::vector<uint8_t> samples = largeVector<uint8_t>(count);
    Signals signals;
    signals.gathered = largeVector<NoisyLight>(count);
    signals.direct = largeVector<NoisyLight>(hasDirect ? count : 0);
    signals.moments = largeVector<vec3>(directions ? count : 0);
    forEachIndex(count, [&](std::size_t i) {
        const IrradianceEstimate& e = estimates[i];
        valid[i] = e.valid ? 1 : 0;
        samples[i] = DenoiserTexels::samplesOf(e);
        signals.set(i, e);
    });
    const Status status = denoiseComponents({geometry, map, grid, valid, samples}, std::span(&signals, 1), device);
    if (status || status.error().code == ErrorCode::Unsupported) writeTo(estimates, signals);
    return status;
}

void denoise(const BakeGeometry& geometry, const TexelMap& map, std::span<const SeamSample> seams,
             std::vector<IrradianceEstimate>& estimates, bool directions)
{
    static_cast<void>(denoise(geometry, map, seams, estimates, directions, DeviceDenoiser{}));
}

} // namespace halflight
