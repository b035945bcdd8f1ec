#include "bake_cpu/baked_lights.h"

#include "bake_cpu/shadow_rays.h"

#include "halflight/base/parallel.h"

#include <algorithm>

namespace halflight {
namespace {

/// Where a texel's points receive amounts that differ by more than this share of the most, more points are asked.
constexpr float kAlike = 0.05f;
constexpr int kMostBatches = 64;

/// What lights without shadows give a texel, on average over its points.
class Unshadowed {
public:
    struct Light {
        vec3 irradiance{0.0f};
        vec3 moment{0.0f}; ///< first moment of its luminance's direction
    };

    Unshadowed(const ShadowPass& pass, std::size_t number)
        : pass_(pass), texel_(pass.map.texels[pass.texels[number]]), mask_(pass.outside[number])
    {}

    Light of(const PunctualLight& light)
    {
        float least = kInfinity;
        float most = 0.0f;
        Light sum;
        std::size_t count = 0;
        const auto add = [&](int batch) {
            for (const SurfacePoint& point : pointsOf(batch)) {
                const shading::LightSample s = light.at(point.position);
                const vec3 value = irradianceOn(point.normal, s);
                const float weight = luminance(value);
                sum.irradiance += value;
                sum.moment += weight * s.direction;
                least = std::min(least, weight);
                most = std::max(most, weight);
                ++count;
            }
        };
        add(0);
        // Folded texels have as many points as shadow edges have rays. Those with points left out have no others.
        if (most - least > kAlike * most && mask_ == kAllPoints) {
            const int batches = std::min(pass_.timesOnEdges * pass_.samples / kMaxTexelPoints, kMostBatches);
            for (int batch = 1; batch < batches; ++batch) add(batch);
        }
        return {sum.irradiance / float(count), sum.moment / float(count)};
    }

private:
    std::span<const SurfacePoint> pointsOf(int batch)
    {
        if (std::size_t(batch) == batches_.size()) {
            Batch& b = batches_.emplace_back();
            const int first = mask_ == kAllPoints ? ShadowGroup::firstBatch(texelId(pass_.map, texel_)) : 0;
            b.count = texelPoints(pass_.paths.surfaces().geometry(), pass_.map, texel_, b.points, first + batch);
            PointValidity::keep(mask_, b.points, b.count);
        }
        const Batch& b = batches_[std::size_t(batch)];
        return {b.points.data(), std::size_t(b.count)};
    }

    struct Batch {
        TexelPoints points;
        int count = 0;
    };
    const ShadowPass& pass_;
    const Texel& texel_;
    PointMask mask_;
    std::vector<Batch> batches_;
};

} // namespace

bool addBakedLights(const ShadowPass& pass, uint32_t seed, std::span<IrradianceEstimate> out)
{
    // A few lights at a time, so that memory stays small.
    constexpr std::size_t kLightsAtOnce = 4;
    std::vector<const PunctualLight*> lights;
    for (const PunctualLight& light : pass.paths.lights()) {
        if (light.directAtTexels) lights.push_back(&light);
    }
    const auto rays = float(pass.timesOnEdges * pass.samples);
    for (std::size_t first = 0; first < lights.size(); first += kLightsAtOnce) {
        const std::size_t count = std::min(kLightsAtOnce, lights.size() - first);
        std::vector<ShadowSource> sources;
        for (std::size_t l = first; l < first + count; ++l)
            sources.push_back({{lights[l]}, true, hashCombine(seed, uint32_t(l))});
        std::vector<LitCount> counts;
        if (!traceShadows(pass, sources, counts)) return false;
        const auto addLights = [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                if (!out[i].valid) continue;
                Unshadowed unshadowed(pass, i);
                for (std::size_t l = 0; l < count; ++l) {
                    const LitCount& lit = counts[i * count + l];
                    if (!lit.any()) continue;
                    const float strength = lights[first + l]->shadowStrength;
                    const float arrives = glm::mix(1.0f, lit.share(), strength);
                    if (arrives <= 0.0f) continue;
                    const Unshadowed::Light light = unshadowed.of(*lights[first + l]);
                    out[i].irradiance += arrives * light.irradiance;
                    out[i].direct += arrives * light.irradiance;
                    out[i].moment += arrives * light.moment;
                    // Of a share of so many yes-or-no rays, as if they were independent: texels lit in part have all.
                    const float contrast = lit.mixed() ? luminance(light.irradiance) * strength : 0.0f;
                    const float variance = contrast * contrast * lit.share() * (1.0f - lit.share()) / rays;
                    out[i].varianceOfMean += variance;
                    out[i].varianceOfDirect += variance;
                }
            }
        };
        if (!parallelFor(pass.texels.size(), 1024, pass.progress, pass.stage, addLights)) return false;
    }
    return true;
}

} // namespace halflight
