// Outliers of gathered light: fireflies (few paths with a large contribution) and dark specks (no path with one). C++
// and GLSL 4.60 compile this file (halflight/shading/language.h). Field is a type with a member `grid`
// (surface_walk.h), and these functions, besides NeighbourValues and those of neighbour_values.h:
//   bool isValid(Field, uint texel)              outside geometry
//   bool isWhole(Field, uint texel)              covered for the most part, with no sample point inside geometry
//   bool hasFewSamples(Field, uint texel)        fewer than kReliableSamples
//   NoisyLight statedLight(Field, uint texel)    gathered light as the estimates state it
//   NoisyLight scaledLight(Field, uint texel)    the same with the calibrated variance
#ifndef HALFLIGHT_BAKE_OUTLIERS_H
#define HALFLIGHT_BAKE_OUTLIERS_H

#ifdef __cplusplus
#include "bake/denoise/neighbour_values.h"
#endif
#include "bake/seams/surface_walk.h"

#include "halflight/shading/denoise.h"

HL_NAMESPACE_BEGIN

// Adjacent texels that hold this share of an outlier's excess confirm it: the light is real.
HL_CONST float kConfirmingShare = 0.25f;
HL_CONST uint kReliableSamples = 128u; // from there on chance does not explain a difference
HL_CONST int kFewestNeighbours = 8;    // below, quantiles of the neighbourhood mean nothing

// Statistics of gathered light around one texel, on its surface: over 5 × 5 texels. "Adjacent" are the 3 × 3.
struct NeighbourStats {
    int count; // neighbours, without the texel itself; NeighbourValues has theirs
    int adjacentCount;
    vec2 brightestAdjacent; // the two largest luminances of adjacent texels, descending
    vec2 darkestAdjacent;   // the two smallest, ascending
    vec3 irradianceSum;     // over the neighbours
    float varianceSum;      // weighted, the texel itself included, each clamped to 4 × the texel's own
    float varianceWeight;   // sum of the weights; 0 without any valid texel
};

// The texel that the statistics belong to.
struct OutlierTexel {
    float luminance;
    float variance;       // calibrated
    float statedVariance; // as estimated by the integrator
    bool few;             // fewer samples than prove that light is real
    bool whole;
};

HL_FN void addAdjacent(HL_INOUT(NeighbourStats) stats, float luminance)
{
    vec2 bright = stats.brightestAdjacent;
    vec2 dark = stats.darkestAdjacent;
    ++stats.adjacentCount;
    stats.brightestAdjacent = vec2(max(bright.x, luminance), max(bright.y, min(bright.x, luminance)));
    stats.darkestAdjacent = vec2(min(dark.x, luminance), min(dark.y, max(dark.x, luminance)));
}

HL_FN_OF(Field)
NeighbourStats neighbourStats(HL_IN(Field) field, uint texel, HL_INOUT(NeighbourValues) values)
{
    NeighbourStats stats;
    stats.count = 0;
    stats.adjacentCount = 0;
    stats.brightestAdjacent = vec2(0.0f);
    stats.darkestAdjacent = vec2(3.0e38f);
    stats.irradianceSum = vec3(0.0f);
    stats.varianceSum = 0.0f;
    stats.varianceWeight = 0.0f;
    float most = 4.0f * scaledLight(field, texel).variance + 1.0e-12f;
    for (int dy = -2; dy <= 2; ++dy) {
        for (int dx = -2; dx <= 2; ++dx) {
            uint j = texelOnSurface(field.grid, texel, ivec2(dx, dy));
            if (j == kNowhere || !isValid(field, j)) continue;
            NoisyLight light = scaledLight(field, j);
            if (j != texel) {
                float other = luminanceOf(light.irradiance);
                stats.irradianceSum += light.irradiance;
                keepNeighbour(values, stats.count, other, light.variance);
                ++stats.count;
                if (max(abs(dx), abs(dy)) <= 1) addAdjacent(stats, other);
            }
            float w = 1.0f / (1.0f + float(dx * dx + dy * dy));
            stats.varianceSum += w * min(light.variance, most);
            stats.varianceWeight += w;
        }
    }
    return stats;
}

// Ranks of the 1/8 and the 7/8 quantile.
HL_FN int lowRank(int count)
{
    return count / 8;
}
HL_FN int highRank(int count)
{
    return count - count / 8;
}

// Whether a texel lies in the midst of a surface.
HL_FN bool isAmid(NeighbourStats stats, OutlierTexel texel)
{
    return texel.whole && stats.adjacentCount == 8;
}

// Few samples, in the midst of a surface. Half blocks agree by chance in one of some thousand such texels, so that a
// small stated variance does not prove light to be real.
HL_FN bool mayAgreeByChance(NeighbourStats stats, OutlierTexel texel)
{
    return isAmid(stats, texel) && texel.few;
}

// The variance that the filter uses for a texel. A variance estimate is noisy itself, so it is averaged with its
// neighbours'. The clamp to 4 × its own value keeps the variance beside a bright light from opening a dark texel's
// filter. A texel without a bright path has a variance near zero by chance: the median of its neighbourhood is a lower
// bound, and in the midst of a surface half the 7/8 quantile.
HL_FN float smoothedVariance(NeighbourStats stats, HL_INOUT(NeighbourValues) values, OutlierTexel texel)
{
    float variance = texel.variance;
    if (stats.varianceWeight > 0.0f) variance = max(stats.varianceSum / stats.varianceWeight, 0.25f * texel.variance);
    int median = stats.count / 2;
    if (stats.count > 0 && varianceRankIsAbove(values, stats.count, median, variance))
        variance = varianceOfRank(values, stats.count, median);
    int high = highRank(stats.count);
    if (isAmid(stats, texel) && varianceRankIsAbove(values, stats.count, high, 2.0f * variance))
        variance = 0.5f * varianceOfRank(values, stats.count, high);
    return variance;
}

// For a texel below the 1/8 quantile: that quantile, if the texel is a dark speck.
HL_FN float raisedLuminance(NeighbourStats stats, OutlierTexel texel, float dark, float variance)
{
    float lack = dark - texel.luminance;
    bool alone = dark - stats.darkestAdjacent.y < kConfirmingShare * lack;
    return alone && lack > 0.5f * sqrt(variance) ? dark : texel.luminance;
}

// For a texel above the 7/8 quantile: that quantile, if the texel is a firefly. A path with a large contribution makes
// the half blocks of its texel differ by about the excess. Where they agree, the light is real, unless no adjacent
// texel confirms it and chance explains it. The limit is lower at rims, where real differences are common, and where
// adjacent texels confirm the light: a lamp close to a wall lights few texels.
HL_FN float loweredLuminance(NeighbourStats stats, OutlierTexel texel, float bright, float variance)
{
    float excess = texel.luminance - bright;
    bool confirmed = stats.brightestAdjacent.y - bright >= kConfirmingShare * excess;
    bool alone = mayAgreeByChance(stats, texel) && !confirmed;
    float sigmas = !texel.whole ? 2.0f : confirmed ? 3.0f : 5.0f;
    bool isNoise = alone || excess <= sigmas * sqrt(texel.statedVariance);
    bool isFirefly = excess > 0.5f * sqrt(variance) && isNoise;
    return isFirefly ? bright : texel.luminance;
}

// The luminance of a texel after the removal of outliers: its own, the 7/8 quantile of its neighbourhood when the texel
// is a firefly, the 1/8 quantile when it is a dark speck. `variance` is that of smoothedVariance().
HL_FN float luminanceWithoutOutliers(NeighbourStats stats, HL_INOUT(NeighbourValues) values, OutlierTexel texel,
                                     float variance)
{
    float own = texel.luminance;
    int count = stats.count;
    if (count < kFewestNeighbours) return own;
    bool isDark = mayAgreeByChance(stats, texel) && luminanceRankIsAbove(values, count, lowRank(count), own);
    if (isDark) return raisedLuminance(stats, texel, luminanceOfRank(values, count, lowRank(count)), variance);
    if (luminanceRankIsAbove(values, count, highRank(count), own)) return own;
    return loweredLuminance(stats, texel, luminanceOfRank(values, count, highRank(count)), variance);
}

// Light of a texel after its outlier was removed, and by how much its luminance has changed.
struct ClampedTexel {
    NoisyLight light;
    float before;
    float after;
};

HL_FN_OF(Field) ClampedTexel withoutOutlier(HL_IN(Field) field, uint texel)
{
    NeighbourValues values;
    NeighbourStats stats = neighbourStats(field, texel, values);
    ClampedTexel clamped;
    clamped.light = scaledLight(field, texel);
    OutlierTexel own;
    own.luminance = luminanceOf(clamped.light.irradiance);
    own.variance = clamped.light.variance;
    own.statedVariance = statedLight(field, texel).variance;
    own.few = hasFewSamples(field, texel);
    own.whole = isWhole(field, texel);
    clamped.light.variance = smoothedVariance(stats, values, own);
    clamped.before = own.luminance;
    clamped.after = luminanceWithoutOutliers(stats, values, own, clamped.light.variance);
    // Added light has the mean colour of the neighbours: a black texel has no colour of its own.
    if (clamped.after > clamped.before)
        clamped.light.irradiance +=
            stats.irradianceSum * ((clamped.after - clamped.before) / luminanceOf(stats.irradianceSum));
    else if (clamped.after < clamped.before)
        clamped.light.irradiance *= clamped.after / clamped.before;
    return clamped;
}

// Scales the first moment as the luminance of all light changes, so that the mean direction stays.
HL_FN vec3 scaledMoment(vec3 moment, vec3 direct, ClampedTexel clamped)
{
    float unchanged = luminanceOf(direct);
    if (clamped.before == clamped.after || clamped.before + unchanged <= 0.0f) return moment;
    return moment * ((clamped.after + unchanged) / (clamped.before + unchanged));
}

HL_NAMESPACE_END

#endif
