#include "transport/shadows/baked_lights.h"

#include "bake/texels/even_texels.h"

#include "transport/shadows/shadow_rays.h"
#include "transport/shadows/texel_runs.h"

#include "halflight/base/parallel.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

namespace halflight {
namespace {

/// What a point receives of a light without shadows.
struct Received {
    vec3 irradiance{0.0f};
    vec3 moment{0.0f}; ///< luminance of the irradiance times mean direction; shorter by an area light's size
};

/// Moment of what a shadow leaves.
vec3 momentOf(const Received& light, vec3 transmittance)
{
    const bool gray = transmittance.x == transmittance.y && transmittance.x == transmittance.z;
    const float share =
        gray ? transmittance.x : luminance(transmittance * light.irradiance) / luminance(light.irradiance);
    return share * light.moment;
}

// From so many longer half sides on, four points in an area light stand for it: their irradiance errs by 3 times the
// fourth power of half side over distance at most, which is 0.24 %. From a third of that on, sixteen give its
// direction.
constexpr float kFarAreaLight = shading::kNearAreaLight;
constexpr float kNearAreaLight = kFarAreaLight / 3.0f;

/// Sums over points of an area light that is cut `cuts` times along each side; 2 x 2 points of each piece by the rule
/// of Gauss, in a disk with the same second moments. In units of its radiance.
struct AreaSum {
    float irradiance = 0.0f;
    vec3 moment{0.0f};

    AreaSum(const PunctualLight& light, const SurfacePoint& point, int cuts)
    {
        const bool isDisk = light.type == shading::kLightDisk;
        // Pieces of a disk are those of a square whose second moments, and so its points', are the disk's.
        const float side = isDisk ? 0.5f * std::sqrt(3.0f) : 1.0f;
        const float pieceHalf = side / float(cuts);
        const float offset = pieceHalf / std::sqrt(3.0f);
        const float area = light.area / float(4 * cuts * cuts);
        const vec3 toCenter = light.position - point.position;
        for (int i = 0; i < 4 * cuts * cuts; ++i) {
            const int column = i % (2 * cuts);
            const int row = i / (2 * cuts);
            const float x = float(2 * (column / 2) + 1) * pieceHalf - side + (column % 2 == 0 ? -offset : offset);
            const float y = float(2 * (row / 2) + 1) * pieceHalf - side + (row % 2 == 0 ? -offset : offset);
            const vec3 to = toCenter + x * light.halfWidth + y * light.halfHeight;
            const float distance2 = std::max(glm::dot(to, to), 1.0e-20f);
            const vec3 direction = to / std::sqrt(distance2);
            const float weight = area / distance2 * std::max(glm::dot(point.normal, direction), 0.0f) *
                                 std::max(-glm::dot(light.axis, direction), 0.0f);
            irradiance += weight;
            moment += weight * direction;
        }
    }
};

/// Mean direction of the light that a point receives of a close area light, weighted by irradiance.
vec3 meanDirection(const PunctualLight& light, const SurfacePoint& point)
{
    constexpr int kSide = 4; // strata along each side: directions are within a quarter of the light
    vec3 moment(0.0f);
    float sum = 0.0f;
    for (int i = 0; i < kSide * kSide; ++i) {
        const vec2 u = (vec2(i % kSide, i / kSide) + 0.5f) / float(kSide);
        const LightRay ray = sampleLightRay(light, point.position, shading::sampleDisc(u));
        const float weight = ray.solidAngle * std::max(glm::dot(point.normal, ray.direction), 0.0f);
        moment += weight * ray.direction;
        sum += weight;
    }
    return sum > 0.0f ? moment / sum : glm::normalize(light.position - point.position);
}

Received receivedFrom(const PunctualLight& light, const SurfacePoint& point)
{
    if (!light.isArea()) {
        const shading::LightSample sample = light.at(point.position);
        const vec3 irradiance = irradianceOn(point.normal, sample);
        return {irradiance, luminance(irradiance) * sample.direction};
    }
    const vec3 toCenter = light.position - point.position;
    const float half2 =
        std::max(glm::dot(light.halfWidth, light.halfWidth), glm::dot(light.halfHeight, light.halfHeight));
    const float distance2 = glm::dot(toCenter, toCenter);
    // How far the light reaches above and below the horizon's plane.
    const float above = glm::dot(point.normal, toCenter);
    const float spread =
        std::abs(glm::dot(point.normal, light.halfWidth)) + std::abs(glm::dot(point.normal, light.halfHeight));
    if (above + spread <= 0.0f || glm::dot(light.axis, toCenter) >= 0.0f) return {};
    if (distance2 >= kFarAreaLight * kFarAreaLight * half2 && above > spread) {
        const AreaSum sum(light, point, 1);
        const vec3 radiance = light.radianceAt(point.position);
        return {sum.irradiance * radiance, luminance(radiance) * sum.moment};
    }
    const vec3 irradiance = light.irradianceAt(point.position, point.normal);
    vec3 direction;
    if (distance2 >= kNearAreaLight * kNearAreaLight * half2) {
        const AreaSum sum(light, point, 2);
        direction = sum.irradiance > 0.0f ? sum.moment / sum.irradiance : glm::normalize(toCenter);
    } else {
        direction = meanDirection(light, point);
    }
    return {irradiance, luminance(irradiance) * direction};
}

/// Mean irradiance without shadows over the points of a texel.
class Unshadowed {
public:
    Unshadowed(const ShadowPass& pass, std::size_t number)
        : pass_(pass), texel_(pass.map.texels[pass.texels[number]]), mask_(texel_.validPoints)
    {}

    Received of(const PunctualLight& light)
    {
        float least = kInfinity;
        float most = 0.0f;
        Received sum;
        std::size_t count = 0;
        const auto add = [&](int batch) {
            for (const SurfacePoint& onFront : pointsOf(batch)) {
                // The mean of both sides, one of which receives nothing.
                const bool mean = geometry().hasMeanTexels(onFront.triangle);
                const float share = mean ? 0.5f : 1.0f;
                const SurfacePoint point = mean && isBehindSheet(geometry(), onFront, light.towards(onFront.position))
                                               ? flipped(onFront)
                                               : onFront;
                const Received value = receivedFrom(light, point);
                const float weight = share * luminance(value.irradiance);
                sum.irradiance += share * value.irradiance;
                sum.moment += share * value.moment;
                least = std::min(least, weight);
                most = std::max(most, weight);
                ++count;
            }
        };
        add(0);
        const float even = isFlat() && light.type != shading::kLightSpot ? kEvenOnAPlane : kEvenIrradiance;
        // Texels across a fold take as many points as shadow edges have rays. Partly valid texels have batch 0 only.
        if (most - least > even * most && mask_ == kAllPoints) {
            const int batches = std::min(pass_.timesOnEdges * pass_.samples / kMaxTexelPoints, kMostBatches);
            for (int batch = 1; batch < batches; ++batch) add(batch);
        }
        return {sum.irradiance / float(count), sum.moment / float(count)};
    }

private:
    [[nodiscard]] const BakeGeometry& geometry() const { return pass_.paths.surfaces().geometry(); }
    std::span<const SurfacePoint> pointsOf(int batch)
    {
        if (std::size_t(batch) == batches_.size()) {
            Batch& b = batches_.emplace_back();
            const int first = mask_ == kAllPoints ? ShadowGroup::firstBatch(texelId(pass_.map, texel_)) : 0;
            b.count = texelPoints(geometry(), pass_.map, texel_, b.points, first + batch);
            keepPoints(mask_, b.points, b.count);
        }
        const Batch& b = batches_[std::size_t(batch)];
        return {b.points.data(), std::size_t(b.count)};
    }

    /// Whether the points of batch 0 have one normal.
    bool isFlat()
    {
        const std::span<const SurfacePoint> points = pointsOf(0);
        return std::all_of(points.begin(), points.end(),
                           [&](const SurfacePoint& point) { return point.normal == points[0].normal; });
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

/// Adds the lights' direct light to the texels of a pass. The estimate of its texel i is out[places[i]].
Status addLights(const ShadowPass& pass, std::span<const PunctualLight* const> lights, uint32_t seed,
                 std::span<const uint32_t> places, const TexelLight& out)
{
    std::vector<ShadowSource> sources;
    const PunctualLight* const first = pass.paths.light().lights().data();
    for (const PunctualLight* light : lights)
        sources.push_back({LightReach(std::vector{light}), true, hashCombine(seed, uint32_t(light - first))});
    const auto rays = float(pass.timesOnEdges * pass.samples);
    const Progress shadows = partOf(pass.progress, 0.0, 0.9);
    std::vector<LitSum> counts;
    std::vector<vec3> colors;
    if (Status s = traceShadows(pass.of(pass.texels, shadows), sources, counts, &colors); !s) return s;
    const std::size_t components = out.components.empty() ? 0 : out.components.size() / out.texels.size();
    const auto addTo = [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            IrradianceEstimate& estimate = out.texels[places[i]];
            if (!estimate.valid) continue;
            Unshadowed unshadowed(pass, i);
            for (std::size_t l = 0; l < lights.size(); ++l) {
                const LitSum& lit = counts[i * lights.size() + l];
                if (!lit.any()) continue;
                const float strength = lights[l]->shadowStrength;
                const vec3 share =
                    colors.empty() ? vec3(lit.share()) : glm::min(colors[i * lights.size() + l] / lit.all, vec3(1.0f));
                const vec3 transmittance = shadowOf(*lights[l], share);
                if (transmittance == vec3(0.0f)) continue;
                const Received light = unshadowed.of(*lights[l]);
                // Binomial variance of the lit share; partly lit texels have all rays.
                const float contrast = lit.mixed() ? luminance(light.irradiance) * strength : 0.0f;
                const float variance = contrast * contrast * lit.share() * (1.0f - lit.share()) / rays;
                const auto add = [&](IrradianceEstimate& to) {
                    to.irradiance += transmittance * light.irradiance;
                    to.direct += transmittance * light.irradiance;
                    to.moment += momentOf(light, transmittance);
                    to.varianceOfMean += variance;
                    to.varianceOfDirect += variance;
                };
                add(estimate);
                if (components > 0) add(out.components[places[i] * components + std::size_t(lights[l]->component)]);
            }
        }
    };
    const Progress rest = partOf(pass.progress, 0.9, 1.0);
    return pass.paths.surfaces().outcome(parallelFor(pass.texels.size(), 1024, rest, pass.stage, addTo));
}

/// Lights that reach every texel, up to four at a time: there is a count for each texel and light.
Status addLightsEverywhere(const ShadowPass& pass, std::span<const PunctualLight* const> lights, uint32_t seed,
                           const TexelLight& out)
{
    constexpr std::size_t kLightsAtOnce = 4;
    std::vector<uint32_t> places(lights.empty() ? 0 : pass.texels.size());
    std::iota(places.begin(), places.end(), 0u);
    for (std::size_t first = 0; first < lights.size(); first += kLightsAtOnce) {
        const auto some = lights.subspan(first, std::min(kLightsAtOnce, lights.size() - first));
        const double share = 1.0 / double(lights.size());
        const Progress part = partOf(pass.progress, double(first) * share, double(first + some.size()) * share);
        if (Status s = addLights(pass.of(pass.texels, part), some, seed, places, out); !s) return s;
    }
    return {};
}

/// Lights with a range, block by block of texels, so that cost and memory follow from the lights that reach a texel.
Status addLightsInReach(const ShadowPass& pass, const LightReach& reach, uint32_t seed, const TexelLight& out)
{
    const TexelRuns runs(pass.paths.surfaces().geometry(), pass.map, pass.texels);
    // About 64 x 64 texels: those of the rim, whose neighbourhoods reach into other blocks, are few. A device takes
    // more at once.
    const std::size_t runsOfBlock = pass.device != nullptr ? 4096 : 256;
    const std::size_t blocks = (runs.size() + runsOfBlock - 1) / runsOfBlock;
    const Progress quiet{{}, pass.progress.cancel};
    const auto addBlock = [&](std::size_t block) -> Status {
        const std::size_t firstRun = block * runsOfBlock;
        const std::size_t endRun = std::min(firstRun + runsOfBlock, runs.size());
        const std::vector<const PunctualLight*> lights = reach.near(runs.bounds().subspan(firstRun, endRun - firstRun));
        for (std::size_t first = 0; first < lights.size(); first += kMaxShadowSources) {
            const std::size_t count = std::min(kMaxShadowSources, lights.size() - first);
            const auto some = std::span(lights).subspan(first, count);
            const std::vector<uint32_t> places = runs.reachedBy(some, firstRun, endRun);
            std::vector<uint32_t> texels;
            for (const uint32_t place : places) texels.push_back(pass.texels[place]);
            if (Status s = addLights(pass.of(texels, quiet), some, seed, places, out); !s) return s;
        }
        return {};
    };
    for (std::size_t block = 0; pass.device != nullptr && block < blocks; ++block) {
        if (Status s = addBlock(block); !s) return s;
        pass.progress(pass.stage, double(block + 1) / double(blocks));
    }
    if (pass.device != nullptr) return {};
    const bool finished = parallelFor(blocks, 1, pass.progress, pass.stage, [&](std::size_t begin, std::size_t end) {
        for (std::size_t block = begin; block < end; ++block)
            inIsolation([&] { static_cast<void>(addBlock(block)); }); // outcome() says why
    });
    return pass.paths.surfaces().outcome(finished);
}

} // namespace

Status addBakedLights(const ShadowPass& pass, uint32_t seed, const TexelLight& out)
{
    std::vector<const PunctualLight*> everywhere;
    std::vector<const PunctualLight*> inReach;
    for (const PunctualLight& light : pass.paths.light().lights())
        if (light.directAtTexels) (reachesEverywhere(light) ? everywhere : inReach).push_back(&light);
    const double share = inReach.empty() ? 1.0 : 0.5; // of the progress
    const Progress first = partOf(pass.progress, 0.0, everywhere.empty() ? 0.0 : share);
    const Progress second = partOf(pass.progress, everywhere.empty() ? 0.0 : share, 1.0);
    if (Status s = addLightsEverywhere(pass.of(pass.texels, first), everywhere, seed, out); !s) return s;
    if (!inReach.empty()) {
        const ShadowPass rest = pass.of(pass.texels, second);
        if (Status s = addLightsInReach(rest, LightReach(inReach), seed, out); !s) return s;
    }
    return pass.paths.surfaces().outcome(!pass.progress.cancelled());
}

} // namespace halflight
