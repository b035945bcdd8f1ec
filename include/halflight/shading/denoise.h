// Formulas of the denoiser of lightmaps, which src/bake/denoise/denoise.cpp describes: what taps of its filter count
// for, trends of light, outliers and variances. Taps are places on the surface, 5 × 5 around a texel. Light is in lux.
#ifndef HALFLIGHT_SHADING_DENOISE_H
#define HALFLIGHT_SHADING_DENOISE_H

#include "language.h"
#include "luminance.h"

HL_NAMESPACE_BEGIN

HL_CONST int kTaps = 25; // row by row
HL_CONST int kMiddleTap = 12;

HL_CONST_FN int tapX(int tap)
{
    return tap % 5 - 2;
}
HL_CONST_FN int tapY(int tap)
{
    return tap / 5 - 2;
}
// Of the B3 spline, by the distance along an axis; 0 to 2 taps.
HL_CONST_FN float splineOf(int offset)
{
    return offset == 0 ? 3.0f / 8.0f : offset == 1 || offset == -1 ? 1.0f / 4.0f : 1.0f / 16.0f;
}
HL_CONST_FN float tapSpline(int tap)
{
    return splineOf(tapX(tap)) * splineOf(tapY(tap));
}

// Light, and the variance of its luminance.
struct NoisyLight {
    vec3 irradiance;
    float variance;
};

HL_FN NoisyLight noisyLight(vec3 irradiance, float variance)
{
    NoisyLight light;
    light.irradiance = irradiance;
    light.variance = variance;
    return light;
}

// Light less the direct light of fully baked lights. The denoiser filters both separately: gathered light is noisy and
// smooth, direct light has little noise and sharp edges.
HL_FN NoisyLight gatheredLight(vec3 irradiance, float variance, vec3 direct, float varianceOfDirect)
{
    return noisyLight(irradiance - direct, max(variance - varianceOfDirect, 0.0f));
}

// Direct light is stratified over texel and light; its stated variance is that of independent rays.
HL_FN NoisyLight directLight(vec3 direct, float varianceOfDirect)
{
    return noisyLight(direct, 0.1f * varianceOfDirect);
}

// --- Variances. The stated one is calibrated by second differences: light that is linear along one axis or the other
// --- cancels, so that noise remains (Immerkaer 1996, "Fast Noise Variance Estimation").

// Squared second difference over 3 × 3 texels, and its expectation under the variances that the estimates state.
struct SecondDifference {
    float measured;
    float expected; // 0: there is none
};

HL_FN float secondDifferenceWeight(int dx, int dy)
{
    return float((dx == 0 ? -2 : 1) * (dy == 0 ? -2 : 1));
}

// Factor of a variance from the sums of `count` differences. One more difference counts, as large as stated: few ones
// prove little, and differences of 0 by chance must not switch the filter off.
HL_FN float varianceScale(SecondDifference sums, float count)
{
    if (!(count > 0.0f)) return 1.0f;
    return min((count * sums.measured / sums.expected + 1.0f) / (count + 1.0f), 1.0f);
}

// --- The filter.

HL_CONST int kFilterLevels = 4;

// Ratio of the true variance of a weighted mean to that of independent values, by level. Values of level 2 and up share
// texels. On an even surface k levels are a kernel of variance (4^k - 1) / 3 along each axis. These kernels average
// 12.6, 63, 264 and 1070 texels. Independent values would multiply the number by 13.4 at each level.
HL_FN float correlationOf(int level)
{
    return level == 0 ? 1.0f : level == 1 ? 2.7f : level == 2 ? 3.2f : 3.3f;
}

HL_FN float pow32(float x)
{
    float x2 = x * x;
    float x4 = x2 * x2;
    float x8 = x4 * x4;
    float x16 = x8 * x8;
    return x16 * x16;
}

// exp(-x) approximated by (1 - x / 32)^32; 0 from x = 32 on.
HL_FN float falloff(float x)
{
    return pow32(max(1.0f - x * (1.0f / 32.0f), 0.0f));
}

// What the filter reads at a tap.
struct Tap {
    bool valid; // on the surface, and outside geometry
    vec3 position;
    vec3 normal; // unit
    NoisyLight gathered;
    NoisyLight direct;
    vec3 moment;
};

HL_FN Tap noTap()
{
    Tap tap;
    tap.valid = false;
    tap.position = vec3(0.0f);
    tap.normal = vec3(0.0f);
    tap.gathered = noisyLight(vec3(0.0f), 0.0f);
    tap.direct = tap.gathered;
    tap.moment = vec3(0.0f);
    return tap;
}

// Spline × agreement of normals, of which `cosine` is that of the angle. Texels that are adjacent on the map and far
// apart in the world (folded charts) have none. `offset`: from the middle, metres. `valid`: 1, or 0 for no tap.
HL_FN float tapNearness(vec3 offset, float cosine, float spline, float valid, float tapsPerMeter)
{
    const float kFarTaps = 8.0f; // the corner of 5 × 5 is 2.8 away on a flat chart
    float within = dot(offset, offset) * tapsPerMeter * tapsPerMeter > kFarTaps * kFarTaps ? 0.0f : valid;
    return within * spline * pow32(cosine);
}

// Smallest cosine between the normals of taps on one side of a surface, and not round a corner or a crease: 18 degrees.
HL_CONST float kSameSideOfTaps = 0.95f;

// How gathered light changes around a texel: a polynomial of the offset in taps, 0 at the texel.
struct Trend {
    vec3 x; // lux per tap
    vec3 y;
    vec3 xx; // lux per squared tap
    vec3 xy;
    vec3 yy;
    float noise; // ratio of the variances of a mean less the trend and of a plain mean
};

HL_FN Trend flatTrend()
{
    Trend trend;
    trend.x = vec3(0.0f);
    trend.y = vec3(0.0f);
    trend.xx = vec3(0.0f);
    trend.xy = vec3(0.0f);
    trend.yy = vec3(0.0f);
    trend.noise = 1.0f;
    return trend;
}

// Sums over taps of weights times the terms of a trend.
struct TermSums {
    float x;
    float y;
    float xx;
    float xy;
    float yy;
};

HL_FN vec3 sumOfTrend(Trend trend, TermSums weights)
{
    return weights.x * trend.x + weights.y * trend.y + weights.xx * trend.xx + weights.xy * trend.xy +
           weights.yy * trend.yy;
}

// The smaller of two differences if they have one sign, else 0 (the minmod limiter, Roe 1986): the slope of a gradient,
// and nearly nothing at edges, creases and in noise.
HL_FN float minmod(float a, float b)
{
    return a * b > 0.0f ? (abs(a) < abs(b) ? a : b) : 0.0f;
}

// Change of light from tap to tap, of the middle and of two taps on opposite sides.
HL_FN vec3 slopeOfTaps(vec3 behind, vec3 own, vec3 ahead)
{
    const float kTapsBetween = 2.0f; // from each to the middle
    vec3 a = ahead - own;
    vec3 b = own - behind;
    return vec3(minmod(a.x, b.x), minmod(a.y, b.y), minmod(a.z, b.z)) / kTapsBetween;
}

// Sums over all 5 × 5 taps: of light, and of light times the terms of a trend.
struct LightSums {
    vec3 all;
    vec3 x;
    vec3 y;
    vec3 xx;
    vec3 xy;
    vec3 yy;
};

// The polynomial of second order with the least squares over 5 × 5 taps, whose terms have these sums of squares.
HL_FN Trend fittedTrend(LightSums light)
{
    const float kLinear = 50.0f;
    const float kSquare = 70.0f; // of x^2 - 2
    const float kMixed = 100.0f;
    vec3 twice = 2.0f * light.all;
    Trend trend;
    trend.x = light.x / kLinear;
    trend.y = light.y / kLinear;
    trend.xx = (light.xx - twice) / kSquare;
    trend.xy = light.xy / kMixed;
    trend.yy = (light.yy - twice) / kSquare;
    trend.noise = 2.1f; // of the mean weighted by the spline: 0.165 instead of 0.079
    return trend;
}

// Of what slopes explain, a fitted trend may explain somewhat less: means less it have less bias.
HL_CONST float kEnoughExplained = 0.75f;

// What the luminance of taps is compared with: that of the middle, and the trend's.
struct TapComparison {
    float own;
    float variance;
    float least; // of what differences are compared with, lux²
    float x;
    float y;
    float xx;
    float xy;
    float yy;
};

// Differences below `tolerance` (lux) count little.
HL_FN TapComparison tapComparison(float luminance, float variance, Trend trend, float tolerance)
{
    TapComparison to;
    to.own = luminance;
    to.variance = variance;
    to.least = tolerance * tolerance + 1.0e-12f;
    to.x = luminanceOf(trend.x);
    to.y = luminanceOf(trend.y);
    to.xx = luminanceOf(trend.xx);
    to.xy = luminanceOf(trend.xy);
    to.yy = luminanceOf(trend.yy);
    return to;
}

// The squared difference of a tap's luminance from the middle's, less the trend, over the noise that is expected: the
// exponent of a weight exp(-x).
HL_FN float tapDistance(TapComparison to, float luminance, float variance, float x, float y, float xx, float xy,
                        float yy)
{
    const float kSigmas = 2.0f; // standard deviations: 95 % of the noise
    float change = x * to.x + y * to.y + xx * to.xx + xy * to.xy + yy * to.yy;
    float difference = luminance - to.own - change;
    float noise = 2.0f * kSigmas * kSigmas * min(to.variance, 4.0f * variance) + to.least;
    return difference * difference / noise;
}

// Directions stop at edges of direct light: differences of this share count.
HL_CONST float kMomentTolerance = 0.2f;

// Sum of weights below which taps differ from a texel by far more than noise. Its square is a float that no device
// takes for 0.
HL_CONST float kLeastWeight = 1.0e-16f;

// A weighted mean, and its variance: that of independent values times `correlation`. It is never noisier than the
// middle tap. `variance`: sum of squared weights times variances; `light`: sum of weighted light less the trend.
HL_FN NoisyLight meanOfTaps(NoisyLight own, float weight, float variance, vec3 light, float correlation)
{
    if (!(weight > kLeastWeight)) return own;
    return noisyLight(light / weight, min(correlation * variance / (weight * weight), own.variance));
}

HL_NAMESPACE_END

#endif
