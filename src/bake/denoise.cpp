#include "bake/stages.h"

#include "halflight/bake/texel_grid.h"
#include "halflight/base/parallel.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace halflight {
namespace {

/// Texels that have samples of their own; the others are the mean of some around them, and know nothing more.
bool traced(const IrradianceEstimate& estimate)
{
    return estimate.valid && estimate.samples > 0;
}

/// Light by which an estimate is made up, denoised apart: what rays over the hemisphere gather, noisy and smooth; what
/// fully baked lights bring, hardly noisy and with sharp edges.
struct NoisyLight {
    vec3 irradiance{0.0f};
    float variance = 0.0f; ///< of its luminance
};
NoisyLight gathered(const IrradianceEstimate& e)
{
    return {e.irradiance - e.direct, std::max(e.varianceOfMean - e.varianceOfDirect, 0.0f)};
}

/// What the variances that estimates state have to be multiplied with. They take halves of blocks of samples for
/// independent, which are spread better than that: the true noise is less, the more so the more blocks there are. How
/// much there is shows between neighbours: in second differences along both axes, which smooth light leaves at zero
/// (Immerkaer 1996, "Fast Noise Variance Estimation"), squared and summed over a few texels around, over what the
/// variances let expect of them.
std::vector<float> varianceScales(const TexelMap& map, const TexelGrid& grid,
                                  const std::vector<IrradianceEstimate>& estimates)
{
    struct Noise {
        float found = 0.0f;
        float stated = 0.0f;
    };
    std::vector<Noise> noise(map.texels.size());
    parallelFor(map.texels.size(), 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            if (!traced(estimates[i])) continue;
            for (int distance = 1; distance <= 4; distance *= 2) {
                float difference = 0.0f;
                float variance = 0.0f;
                int count = 0;
                for (int dy = -1; dy <= 1; ++dy) {
                    for (int dx = -1; dx <= 1; ++dx) {
                        const uint32_t j = grid.at(map.texels[i], dx * distance, dy * distance);
                        if (j == kNoTexel || !traced(estimates[j])) continue;
                        const float weight = float((dx == 0 ? -2 : 1) * (dy == 0 ? -2 : 1));
                        const NoisyLight light = gathered(estimates[j]);
                        difference += weight * luminance(light.irradiance);
                        variance += weight * weight * light.variance;
                        ++count;
                    }
                }
                if (count < 9) continue;
                noise[i] = {difference * difference, variance};
                break;
            }
        }
    });
    constexpr int kRadius = 3;
    constexpr int kEnough = 6;
    constexpr float kLeastScale = 0.05f;
    std::vector<float> scales(map.texels.size(), 1.0f);
    parallelFor(map.texels.size(), 2048, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            float found = 0.0f;
            float stated = 0.0f;
            int count = 0;
            grid.around(uint32_t(i), kRadius, [&](uint32_t j) {
                found += noise[j].found;
                stated += noise[j].stated;
                count += noise[j].stated > 0.0f ? 1 : 0;
            });
            if (count >= kEnough) scales[i] = std::clamp(found / stated, kLeastScale, 1.0f);
        }
    });
    return scales;
}

/// Whether a texel is covered for the most part, and all of its points are in the open.
bool isWhole(const TexelMap& map, const Texel& texel, const IrradianceEstimate& estimate)
{
    return coveredArea(map, texel) > kMostlyCovered && estimate.outsidePoints == 0xffff;
}

/// Outliers: a texel whose few lucky paths make it far brighter than nearly all of the 5 x 5 around it on the same
/// chart, and whose variance says so, comes down to their brightest eighth. And a texel's variance estimate is itself
/// noisy: it is averaged with its neighbours', each counted at no more than a few times the texel's own, so that a
/// bright light's variance does not open the texels beside it to its light. Where an eighth of those around have more,
/// in the midst of a surface, it was mere chance that the texel itself met nothing: dots that are too many to be
/// outliers are to be spread.
/// Texels that are the mean of traced ones tell nothing about these: where they are many of those around, a traced
/// texel is held against traced ones of 9 x 9. Those beside an outlier have a share of it, and come down to
/// the brightest of the traced ones next to them.
/// A texel alone that met so little that it is darker than nearly all around it, and knows of no noise, would stay as a
/// dark speck: it comes up to their darkest eighth.
void tameOutliers(const TexelMap& map, const TexelGrid& grid, const std::vector<IrradianceEstimate>& estimates,
                  std::vector<NoisyLight>& light, std::vector<vec3>& moments)
{
    using Values = std::array<float, 81>; ///< of up to 9 x 9
    constexpr float kTraces = 0.25f;
    constexpr int kManyAround = 20;
    constexpr uint32_t kSamplesToBelieve = 128;
    constexpr int kManyBetween = 6;
    constexpr float kLeft = 0.04f; ///< variance of what was an outlier, of its light squared
    const std::vector<NoisyLight> before = light;
    const auto isBetween = [](const IrradianceEstimate& e) { return e.valid && !traced(e); };
    const bool anyBetween = std::any_of(estimates.begin(), estimates.end(), isBetween);
    const auto scaleMoment = [&](std::size_t i, float own, float now) {
        const float direct = luminance(estimates[i].direct);
        if (own + direct > 0.0f) moments[i] *= (now + direct) / (own + direct);
    };
    const auto bringDown = [&](std::size_t i, float own, float bright) {
        light[i].irradiance *= bright / own;
        scaleMoment(i, own, bright);
        light[i].variance = std::min(light[i].variance, bright * bright * kLeft);
    };
    // What it lacks has the colour of those around it: of black there is none to tell.
    const auto bringUp = [&](std::size_t i, float own, float dark, vec3 sumAround) {
        light[i].irradiance += sumAround * ((dark - own) / luminance(sumAround));
        scaleMoment(i, own, dark);
        light[i].variance = std::max(light[i].variance, dark * dark * kLeft);
    };
    parallelFor(light.size(), 2048, [&](std::size_t begin, std::size_t end) {
        Values around;
        Values variancesAround;
        for (std::size_t i = begin; i < end; ++i) {
            int n = 0;
            int adjacent = 0;
            vec2 brightestAdjacent(0.0f); ///< and the one after it
            vec2 darkestAdjacent(kInfinity);
            vec3 sumAround(0.0f);
            float varianceSum = 0.0f;
            float weight = 0.0f;
            const float own = luminance(before[i].irradiance);
            const float ownVariance = before[i].variance;
            const bool isTraced = traced(estimates[i]);
            int between = 0;
            if (isTraced && anyBetween)
                grid.around(uint32_t(i), 2, [&](uint32_t j) { between += isBetween(estimates[j]) ? 1 : 0; });
            const int step = between > kManyBetween ? 2 : 1;
            for (int dy = -2 * step; dy <= 2 * step; ++dy) {
                for (int dx = -2 * step; dx <= 2 * step; ++dx) {
                    const uint32_t j = grid.at(map.texels[i], dx, dy);
                    if (j == kNoTexel || !estimates[j].valid || (isTraced && !traced(estimates[j]))) continue;
                    if (j != uint32_t(i)) {
                        sumAround += before[j].irradiance;
                        around[std::size_t(n)] = luminance(before[j].irradiance);
                        if (std::max(std::abs(dx), std::abs(dy)) <= step) {
                            ++adjacent;
                            const float other = around[std::size_t(n)];
                            brightestAdjacent.y = std::max(brightestAdjacent.y, std::min(brightestAdjacent.x, other));
                            brightestAdjacent.x = std::max(brightestAdjacent.x, other);
                            darkestAdjacent.y = std::min(darkestAdjacent.y, std::max(darkestAdjacent.x, other));
                            darkestAdjacent.x = std::min(darkestAdjacent.x, other);
                        }
                        variancesAround[std::size_t(n++)] = before[j].variance;
                    }
                    const float w = 1.0f / (1.0f + float(dx * dx + dy * dy) / float(step * step));
                    varianceSum += w * std::min(before[j].variance, 4.0f * ownVariance + 1.0e-12f);
                    weight += w;
                }
            }
            const bool whole = isWhole(map, map.texels[i], estimates[i]);
            const int eighth = n - n / 8; // from there on
            const auto nth = [n](Values& values, int number) {
                std::nth_element(values.begin(), values.begin() + number, values.begin() + n);
                return values[std::size_t(number)];
            };
            // Whether the one of a number in ascending order is above a bound: mostly it is not, and need not be found.
            const auto nthIsAbove = [n](const Values& values, int number, float bound) {
                int above = 0;
                for (int k = 0; k < n; ++k) above += values[std::size_t(k)] > bound ? 1 : 0;
                return above >= n - number;
            };
            float& variance = light[i].variance;
            variance = weight > 0.0f ? std::max(varianceSum / weight, 0.25f * ownVariance) : ownVariance;
            if (n > 0 && nthIsAbove(variancesAround, n / 2, variance)) variance = nth(variancesAround, n / 2);
            if (whole && n >= kManyAround && nthIsAbove(variancesAround, eighth, 2.0f * variance))
                variance = 0.5f * nth(variancesAround, eighth);
            constexpr float kBrighter = 1.1f;
            if (!isTraced || n < 8) continue;
            // Few halves agree by chance in one of some thousand texels in the midst of a surface: what no two of those
            // next to it have is believed of more samples alone. Off the lattice, half as many are next to it.
            const bool few = whole && adjacent * step >= 8 && estimates[i].samples < kSamplesToBelieve;
            if (few && nthIsAbove(around, n / 8, kBrighter * own)) {
                const float dark = nth(around, n / 8);
                const float lack = dark - own;
                if (dark - darkestAdjacent.y < kTraces * lack && lack > 0.5f * std::sqrt(variance))
                    bringUp(i, own, dark, sumAround);
                continue;
            }
            if (nthIsAbove(around, eighth, own / kBrighter)) continue;
            const float bright = nth(around, eighth);
            const float excess = own - bright;
            // One lucky path makes the texel's own halves differ by as much as it is too bright. Where they agree, and
            // more readily so at the rim of a surface or of what stands on it, it has light that the others do not.
            const float sigmas = whole ? 5.0f : 2.0f;
            const bool alone = few && brightestAdjacent.y - bright < kTraces * excess;
            const bool lucky = alone || excess <= sigmas * std::sqrt(gathered(estimates[i]).variance);
            if (own > kBrighter * bright && excess > 0.5f * std::sqrt(variance) && lucky) bringDown(i, own, bright);
        }
    });
    if (!anyBetween) return;
    parallelFor(light.size(), 2048, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            if (!isBetween(estimates[i])) continue;
            bool tamed = false;
            float brightest = 0.0f;
            grid.around(uint32_t(i), 1, [&](uint32_t j) {
                if (!traced(estimates[j])) return;
                tamed = tamed || light[j].irradiance != before[j].irradiance;
                brightest = std::max(brightest, luminance(light[j].irradiance));
            });
            const float own = luminance(light[i].irradiance);
            if (tamed && own > brightest) bringDown(i, own, brightest);
        }
    });
}

/// How unlike two texels' light is, as the exponent of a weight exp(-x): differences that noise can explain do not
/// count, nor those below `tolerance`.
float unlikeness(const NoisyLight& a, const NoisyLight& b, float tolerance)
{
    constexpr float kLuminanceSigmas = 2.0f;
    const float difference = luminance(b.irradiance - a.irradiance);
    const float noise =
        2.0f * kLuminanceSigmas * kLuminanceSigmas * std::min(a.variance, 4.0f * b.variance) + tolerance * tolerance;
    return difference * difference / (noise + 1.0e-12f);
}

float pow32(float x)
{
    for (int i = 0; i < 5; ++i) x *= x;
    return x;
}

/// exp(-x), nearly: (1 - x / 32)^32, and 0 from 32 on.
float falloff(float x)
{
    return pow32(std::max(1.0f - x * (1.0f / 32.0f), 0.0f));
}

/// The lesser of two differences, where both have one sign (the minmod limiter, Roe 1986): of what rises or falls
/// evenly, that; of edges, creases and noise, little or nothing.
vec3 lesser(vec3 a, vec3 b)
{
    vec3 least(0.0f);
    for (int c = 0; c < 3; ++c) {
        if (a[c] * b[c] > 0.0f) least[c] = std::abs(a[c]) < std::abs(b[c]) ? a[c] : b[c];
    }
    return least;
}

/// Weighted mean.
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
    /// `correlated`: how much more variance there is than if all that was added were independent.
    [[nodiscard]] NoisyLight light(const NoisyLight& own, float correlated) const
    {
        if (!(weight > 0.0f)) return own;
        return {sum / weight, std::min(correlated * variance / (weight * weight), own.variance)};
    }
};

} // namespace

// The edge-avoiding à-trous wavelet of Dammertz et al. 2010 ("Edge-Avoiding À-Trous Wavelet Transform for fast Global
// Illumination Filtering"), its luminance edge-stopping function scaled by the estimates' standard deviation as in
// Schied et al. 2017 ("Spatiotemporal Variance-Guided Filtering"): differences that noise can explain are smoothed,
// larger ones (contact shadows) stay. Texels of other charts never take part. Those that are the mean of others are no
// witnesses beside these: the first level averages traced texels alone. From the second level on, light that rises or
// falls evenly across a surface is level: texels are compared, and averaged, with what the slope adds to them taken off
// (a first-order regression in the manner of Bitterli et al. 2016, "Nonlinearly Weighted First-order Regression for
// Denoising Monte Carlo Renderings"); otherwise only those along lines of equal light would come together. Light of
// fully baked lights goes by its own edges and its own noise, and hides none of the other light's.
void denoise(const BakeGeometry& geometry, const TexelMap& map, std::vector<IrradianceEstimate>& estimates,
             bool directions)
{
    const std::size_t count = map.texels.size();
    const TexelGrid grid(map);
    std::vector<NoisyLight> light(count);
    std::vector<NoisyLight> direct;
    std::vector<vec3> moments(count);
    {
        const std::vector<float> scales = varianceScales(map, grid, estimates);
        for (std::size_t i = 0; i < count; ++i) {
            light[i] = gathered(estimates[i]);
            light[i].variance *= scales[i];
            moments[i] = estimates[i].moment;
        }
        // Stated as if of independent rays, which are spread evenly over the texel and over the light.
        constexpr float kDirectVariance = 0.1f;
        if (std::any_of(estimates.begin(), estimates.end(), [](const auto& e) { return e.direct != vec3(0.0f); })) {
            direct.reserve(count);
            for (const IrradianceEstimate& e : estimates)
                direct.push_back({e.direct, kDirectVariance * e.varianceOfDirect});
        }
    }
    struct Guide {
        TexelPlace place;
        bool valid = false;
        bool traced = false;
    };
    std::vector<Guide> guides(count);
    parallelFor(count, 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            guides[i] = {placeOf(geometry, map, map.texels[i]), estimates[i].valid, traced(estimates[i])};
    });
    tameOutliers(map, grid, estimates, light, moments);

    constexpr std::array<float, 3> kSpline = {3.0f / 8.0f, 1.0f / 4.0f, 1.0f / 16.0f};
    constexpr float kMomentTolerance = 0.2f; ///< of direct light, for the direction of all light
    // From the second level on, what is averaged shares texels: its variance shrinks less than that of independent
    // values would. On an even surface k levels together come to a kernel of variance (4^k - 1) / 3 along each axis,
    // so that 12.6, 63, 264 and 1070 texels stand behind each value, where 13.4 times as many with each level would.
    constexpr std::array<float, 4> kCorrelated = {1.0f, 2.7f, 3.2f, 3.3f};
    std::vector<NoisyLight> nextLight(count);
    std::vector<NoisyLight> nextDirect(direct.size());
    std::vector<vec3> nextMoments(directions ? count : 0);
    for (int level = 0; level < int(kCorrelated.size()); ++level) {
        const int step = 1 << level;
        parallelFor(count, 2048, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const Texel& texel = map.texels[i];
                if (!guides[i].valid) continue;
                const TexelPlace& guide = guides[i].place;
                const float planeScale = 1.0f / (float(step) * guide.texelMeters);
                // What light gains from texel to texel of this level.
                const auto slopeAlong = [&](int x, int y) {
                    constexpr int kSpan = 2;
                    constexpr float kSameSide = 0.9f; // cosine between normals
                    if (level == 0) return vec3(0.0f);
                    const uint32_t ahead = grid.at(texel, kSpan * step * x, kSpan * step * y);
                    const uint32_t behind = grid.at(texel, -kSpan * step * x, -kSpan * step * y);
                    for (const uint32_t j : {ahead, behind}) {
                        if (j == kNoTexel || !guides[j].valid) return vec3(0.0f);
                        if (glm::dot(guides[j].place.normal, guide.normal) < kSameSide) return vec3(0.0f);
                    }
                    const vec3 own = light[i].irradiance;
                    return lesser(light[ahead].irradiance - own, own - light[behind].irradiance) / float(kSpan);
                };
                // Direct light without noise is what it is.
                const bool noisyDirect = !direct.empty() && direct[i].variance > 0.0f;
                const vec3 slopeX = slopeAlong(1, 0);
                const vec3 slopeY = slopeAlong(0, 1);
                // At the rim of a chart, a texel without a counterpart on the other side would move the mean to its
                // side: in a dark corner, into the light. There those along the rim alone take part, but for texels
                // that have no pairs of others around them.
                std::array<uint32_t, 25> around;
                for (int k = 0; k < 25; ++k) {
                    const uint32_t j = grid.at(texel, (k % 5 - 2) * step, (k / 5 - 2) * step);
                    around[std::size_t(k)] = j != kNoTexel && guides[j].valid ? j : kNoTexel;
                }
                const auto counts = [&](std::size_t k) {
                    return around[k] != kNoTexel && (level > 0 || guides[around[k]].traced);
                };
                bool pairs = false;
                for (std::size_t k = 0; k < 12; ++k) pairs = pairs || (counts(k) && counts(24 - k));
                const float momentTolerance =
                    direct.empty() ? 0.0f : kMomentTolerance * luminance(direct[i].irradiance);
                Mean lightMean;
                Mean directMean;
                vec3 momentSum(0.0f);
                float momentWeight = 0.0f;
                for (int dy = -2; dy <= 2; ++dy) {
                    for (int dx = -2; dx <= 2; ++dx) {
                        const auto k = std::size_t(5 * dy + dx + 12);
                        const uint32_t j = around[k];
                        if (j == kNoTexel || (pairs && j != uint32_t(i) && !counts(24 - k))) continue;
                        float near = kSpline[std::size_t(std::abs(dx))] * kSpline[std::size_t(std::abs(dy))];
                        float away2 = 0.0f; // off the texel's plane
                        float unlike = 0.0f;
                        const NoisyLight flat = {light[j].irradiance - float(dx) * slopeX - float(dy) * slopeY,
                                                 light[j].variance};
                        const bool other = j != uint32_t(i);
                        if (other) {
                            const TexelPlace& place = guides[j].place;
                            const float cosine = std::max(glm::dot(guide.normal, place.normal), 0.0f);
                            const vec3 offset = place.position - guide.position;
                            const float plane = std::abs(glm::dot(offset, guide.normal)) * planeScale;
                            // Neighbours in the map that are far apart in the world (folded charts) are no neighbours.
                            constexpr float kFarApart = 8.0f;
                            constexpr float kNothing = 1.0e-6f;
                            if (glm::dot(offset, offset) * planeScale * planeScale > kFarApart * kFarApart) continue;
                            near *= pow32(cosine);
                            if (near < kNothing) continue;
                            away2 = plane * plane;
                            unlike = away2 + unlikeness(light[i], flat, 0.0f);
                        }
                        const float weight = near * falloff(unlike);
                        if (noisyDirect) {
                            const float unlikeDirect = other ? unlikeness(direct[i], direct[j], 0.0f) : 0.0f;
                            directMean.add(near * falloff(away2 + unlikeDirect), direct[j]);
                        }
                        if (level == 0 && !guides[j].traced) continue;
                        lightMean.add(weight, flat);
                        if (!directions) continue;
                        const float alike = !direct.empty() && other
                                                ? falloff(unlikeness(direct[i], direct[j], momentTolerance))
                                                : 1.0f;
                        momentSum += weight * alike * moments[j];
                        momentWeight += weight * alike;
                    }
                }
                nextLight[i] = lightMean.light(light[i], kCorrelated[std::size_t(level)]);
                if (directions) nextMoments[i] = momentWeight > 0.0f ? momentSum / momentWeight : moments[i];
                if (!direct.empty()) nextDirect[i] = directMean.light(direct[i], kCorrelated[std::size_t(level)]);
            }
        });
        light.swap(nextLight);
        direct.swap(nextDirect);
        if (directions) moments.swap(nextMoments);
    }
    for (std::size_t i = 0; i < count; ++i) {
        if (!estimates[i].valid) continue;
        const NoisyLight own = direct.empty() ? NoisyLight{} : direct[i];
        estimates[i].irradiance = light[i].irradiance + own.irradiance;
        estimates[i].direct = own.irradiance;
        estimates[i].moment = moments[i];
        estimates[i].varianceOfMean = light[i].variance + own.variance;
        estimates[i].varianceOfDirect = own.variance;
    }
}

} // namespace halflight
