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

/// What the variances that estimates state have to be multiplied with. They take a texel's blocks of samples for
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
                        difference += weight * luminance(estimates[j].irradiance);
                        variance += weight * weight * estimates[j].varianceOfMean;
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

} // namespace

// The edge-avoiding à-trous wavelet of Dammertz et al. 2010 ("Edge-Avoiding À-Trous Wavelet Transform for fast Global
// Illumination Filtering"), its luminance edge-stopping function scaled by the estimates' standard deviation as in
// Schied et al. 2017 ("Spatiotemporal Variance-Guided Filtering"): differences that noise can explain are smoothed,
// larger ones (contact shadows) stay. Texels of other charts never take part. Those that are the mean of others are no
// witnesses beside these: the first level averages traced texels alone.
void denoise(const BakeGeometry& geometry, const TexelMap& map, std::vector<IrradianceEstimate>& estimates)
{
    const std::size_t count = map.texels.size();
    const TexelGrid grid(map);
    const std::vector<float> scales = varianceScales(map, grid, estimates);
    for (std::size_t i = 0; i < count; ++i) estimates[i].varianceOfMean *= scales[i];
    std::vector<TexelPlace> guides(count);
    parallelFor(count, 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) guides[i] = placeOf(geometry, map, map.texels[i]);
    });

    // Two things first, both from the 5 x 5 neighbours on the same chart. Outliers: a texel whose few lucky paths make
    // it far brighter than nearly all of its neighbours, and whose variance or theirs says so, comes down to their
    // brightest fifth. And a texel's variance estimate is itself noisy: it is averaged with its neighbours', each
    // counted at no more than a few times the texel's own, so that a bright light's variance does not open the texels
    // beside it to its light.
    std::vector<vec3> color(count);
    std::vector<vec3> moment(count);
    std::vector<float> variance(count);
    parallelFor(count, 2048, [&](std::size_t begin, std::size_t end) {
        std::array<float, 25> around;
        std::array<float, 25> variancesAround;
        for (std::size_t i = begin; i < end; ++i) {
            const Texel& texel = map.texels[i];
            int n = 0;
            float varianceSum = 0.0f;
            float weight = 0.0f;
            const float own = luminance(estimates[i].irradiance);
            const float ownVariance = estimates[i].varianceOfMean;
            for (int dy = -2; dy <= 2; ++dy) {
                for (int dx = -2; dx <= 2; ++dx) {
                    const uint32_t j = grid.at(texel, dx, dy);
                    if (j == kNoTexel || !estimates[j].valid) continue;
                    if (j != uint32_t(i)) {
                        around[std::size_t(n)] = luminance(estimates[j].irradiance);
                        variancesAround[std::size_t(n++)] = estimates[j].varianceOfMean;
                    }
                    const float w = 1.0f / float(1 + dx * dx + dy * dy);
                    varianceSum += w * std::min(estimates[j].varianceOfMean, 4.0f * ownVariance + 1.0e-12f);
                    weight += w;
                }
            }
            color[i] = estimates[i].irradiance;
            moment[i] = estimates[i].moment;
            variance[i] = weight > 0.0f ? std::max(varianceSum / weight, 0.25f * ownVariance) : ownVariance;
            if (n > 0) {
                std::nth_element(variancesAround.begin(), variancesAround.begin() + n / 2, variancesAround.begin() + n);
                variance[i] = std::max(variance[i], variancesAround[std::size_t(n / 2)]);
            }
            if (n >= 8) {
                std::nth_element(around.begin(), around.begin() + (n - n / 5), around.begin() + n);
                const float bright = around[std::size_t(n - n / 5)];
                const float excess = own - bright;
                // A variance of a few blocks may be small by chance where all of them were lucky. So a little too
                // bright is noise wherever there is any, and far too bright what the neighbours' noise may yet explain.
                const float sigma = std::sqrt(variance[i]);
                const bool slight = own < 1.5f * bright && sigma > 0.005f * bright;
                if (own > 1.1f * bright && excess > 0.5f * sigma && (slight || excess < 8.0f * sigma)) {
                    color[i] *= bright / own;
                    moment[i] *= bright / own;
                    variance[i] = std::min(variance[i], bright * bright * 0.04f);
                }
            }
        }
    });

    constexpr std::array<float, 3> kSpline = {3.0f / 8.0f, 1.0f / 4.0f, 1.0f / 16.0f};
    constexpr float kLuminanceSigmas = 2.0f;
    // From the second level on, what is averaged shares texels: its variance shrinks less than that of independent
    // values would. On an even surface k levels together come to a kernel of variance (4^k - 1) / 3 along each axis,
    // so that 12.6, 63, 264 and 1070 texels stand behind each value, where 13.4 times as many with each level would.
    constexpr std::array<float, 4> kCorrelated = {1.0f, 2.7f, 3.2f, 3.3f};
    std::vector<vec3> nextColor(count);
    std::vector<vec3> nextMoment(count);
    std::vector<float> nextVariance(count);
    for (int level = 0; level < int(kCorrelated.size()); ++level) {
        const int step = 1 << level;
        parallelFor(count, 2048, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const Texel& texel = map.texels[i];
                const TexelPlace& guide = guides[i];
                const float ownLuminance = luminance(color[i]);
                const float planeScale = 1.0f / (float(step) * guide.texelMeters);
                vec3 sum(0.0f);
                vec3 momentSum(0.0f);
                float weight = 0.0f;
                float varianceSum = 0.0f;
                for (int dy = -2; dy <= 2; ++dy) {
                    for (int dx = -2; dx <= 2; ++dx) {
                        const uint32_t j = grid.at(texel, dx * step, dy * step);
                        if (j == kNoTexel || !estimates[j].valid || (level == 0 && !traced(estimates[j]))) continue;
                        float w = kSpline[std::size_t(std::abs(dx))] * kSpline[std::size_t(std::abs(dy))];
                        if (j != uint32_t(i)) {
                            const float cosine = std::max(glm::dot(guide.normal, guides[j].normal), 0.0f);
                            const vec3 offset = guides[j].position - guide.position;
                            const float plane = std::abs(glm::dot(offset, guide.normal)) * planeScale;
                            // Neighbours in the map that are far apart in the world (folded charts) are no neighbours.
                            const float away = glm::length(offset) * planeScale;
                            if (away > 8.0f) continue;
                            const float difference = luminance(color[j]) - ownLuminance;
                            const float noise =
                                2.0f * kLuminanceSigmas * kLuminanceSigmas * std::min(variance[i], 4.0f * variance[j]) +
                                1.0e-12f;
                            w *= std::pow(cosine, 32.0f) * std::exp(-plane * plane - difference * difference / noise);
                        }
                        sum += w * color[j];
                        momentSum += w * moment[j];
                        varianceSum += w * w * variance[j];
                        weight += w;
                    }
                }
                nextColor[i] = weight > 0.0f ? sum / weight : color[i];
                nextMoment[i] = weight > 0.0f ? momentSum / weight : moment[i];
                nextVariance[i] =
                    weight > 0.0f
                        ? std::min(kCorrelated[std::size_t(level)] * varianceSum / (weight * weight), variance[i])
                        : variance[i];
            }
        });
        color.swap(nextColor);
        moment.swap(nextMoment);
        variance.swap(nextVariance);
    }
    for (std::size_t i = 0; i < count; ++i) {
        if (!estimates[i].valid) continue;
        estimates[i].irradiance = color[i];
        estimates[i].moment = moment[i];
        estimates[i].varianceOfMean = variance[i];
    }
}

} // namespace halflight
