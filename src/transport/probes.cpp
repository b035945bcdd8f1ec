#include "transport/probes.h"

#include "transport/sample/running_moments.h"
#include "transport/sample/share_rays.h"

#include "halflight/base/parallel.h"
#include "halflight/shading/sampling.h"
#include "halflight/shading/sh.h"

#include <algorithm>
#include <array>
#include <vector>

namespace halflight {
namespace {

constexpr uint32_t kProbeSeed = 0x5eed0003u;
/// Baked lights whose shadows a probe traces with all its shadow rays. More lights share the rays of so many.
constexpr std::size_t kLightsWithOwnRays = 64;

constexpr float kUniformPdf = 1.0f / (4.0f * kPi); // of directions, per steradian

/// Projects radiance along uniformly distributed directions on spherical harmonics.
class GatheredLight {
public:
    /// What one path brings from its direction, and samples of emitters and of the sky beside it.
    void add(const DirectLight::EmitterInSpace& emitter, const DirectLight::EmitterInSpace& sky, vec3 direction,
             vec3 radiance, bool back)
    {
        for (const auto& light : {emitter, sky})
            if (light.radianceOverPdf != vec3(0.0f)) project(light.direction, light.radianceOverPdf);
        project(direction, radiance / kUniformPdf);
        mean_.add(radiance + (emitter.radianceOverPdf + sky.radianceOverPdf) * kUniformPdf, vec3(0.0f));
        backs_ += back ? 1 : 0;
    }

    /// Sets what follows from all paths.
    void end(ProbeEstimate& estimate) const
    {
        const auto samples = float(mean_.count);
        for (std::size_t i = 0; i < sum_.size(); ++i) estimate.radiance[i] = sum_[i] / samples;
        // A coefficient is 4 pi times the mean of radiance times a basis function, whose mean square is 1 / (4 pi).
        estimate.variance = 4.0f * kPi * mean_.varianceOfMean();
        estimate.valid = backs_ * 4 < mean_.count;
    }

private:
    void project(vec3 direction, vec3 weightedRadiance)
    {
        for (int i = 0; i < 9; ++i) sum_[std::size_t(i)] += weightedRadiance * shading::shBasis(i, direction);
    }

    std::array<vec3, 9> sum_{};
    RunningMoments mean_; ///< of incoming radiance
    uint32_t backs_ = 0;  ///< paths whose first ray hits a hidden back
};

class ProbeTracer {
public:
    ProbeTracer(const PathTracer& paths, const IntegrationSettings& settings, int samples)
        : paths_(paths), settings_(settings), samples_(samples)
    {}

    /// Coefficients of the components, or empty.
    using Components = std::span<SphericalHarmonicsL2>;

    ProbeEstimate trace(uint32_t id, vec3 position, Components components, uint64_t& rays) const
    {
        ProbeEstimate estimate;
        gather(id, position, estimate, components, rays);
        addLights(id, position, estimate, components, rays);
        return estimate;
    }

    /// The gathered light of some probes, and of their components one after another.
    Status gatherOn(const DevicePaths& device, std::span<const vec3> positions, std::span<const uint32_t> which,
                    std::span<ProbeEstimate> out, Components components, uint64_t& rays) const
    {
        const std::size_t count = components.size() / std::max<std::size_t>(which.size(), 1);
        const float share = 1.0f / float(samples_);
        std::vector<DevicePaths::Point> points;
        std::vector<DevicePaths::Item> items;
        for (const uint32_t id : which) {
            items.push_back({id, uint32_t(points.size()), 1});
            points.push_back({positions[id], vec3(0.0f), vec3(0.0f)});
        }
        std::vector<GatheredLight> light(which.size());
        const auto take = [&](std::size_t item, const DevicePaths::Arrival& a, const DevicePaths::Emission& e,
                              std::span<const vec3> ofComponents) {
            light[item].add({e.toEmitter, e.ofEmitter}, {e.toSky, e.ofSky}, a.direction, a.radiance, a.back != 0);
            rays += a.rays;
            const Components to = components.subspan(item * count, count);
            addTo(to, a.emitterComponent, e.ofEmitter * share, e.toEmitter);
            addTo(to, paths_.light().skyComponent(), e.ofSky * share, e.toSky);
            for (std::size_t c = 0; c < count; ++c)
                addTo(to, int(c), ofComponents[c] * (share / kUniformPdf), a.direction);
        };
        const uint32_t seed = settings_.seed ^ kProbeSeed;
        if (Status s = device.traceAll(points, items, seed, uint32_t(samples_), int(count), take); !s) return s;
        for (std::size_t i = 0; i < which.size(); ++i) light[i].end(out[i] = {});
        return {};
    }

    [[nodiscard]] int samples() const { return samples_; }

    /// Light of lights that are fully baked, and occlusion of the others.
    void addLights(uint32_t id, vec3 position, ProbeEstimate& estimate, Components components, uint64_t& rays) const
    {
        addBakedLights(id, position, estimate, components, rays);
        // Of a channel's lights at most one reaches a point.
        paths_.light().forLightsNear(position, [&](const PunctualLight& light, uint32_t l) {
            if (light.channel < 0 || !light.reaches(position)) return;
            const vec3 visible = visibility(light, l, shadowSamples(), id, position, rays);
            for (int c = 0; light.coloredMask && c < 3; ++c) estimate.occlusion[light.channel + c] = visible[c];
            if (!light.coloredMask) estimate.occlusion[light.channel] = grayOf(visible);
        });
    }

private:
    void gather(uint32_t id, vec3 position, ProbeEstimate& estimate, Components components, uint64_t& rays) const
    {
        const float share = 1.0f / float(samples_);
        PathLights lights;
        GatheredLight gathered;
        for (int s = 0; s < samples_; ++s) {
            Sampler sampler(settings_.seed ^ kProbeSeed, id, uint32_t(s));
            const vec3 direction = shading::sampleSphere(sampler.next2());
            const DirectLight::EmitterInSpace emitter =
                paths_.direct().emitterInSpace(position, kUniformPdf, sampler, rays);
            const DirectLight::EmitterInSpace sky = paths_.direct().skyInSpace(position, sampler, rays);
            for (const auto& light : {emitter, sky})
                addTo(components, light.component, light.radianceOverPdf * share, light.direction);
            lights.clear();
            const PathTracer::Incoming in = paths_.incoming({position}, direction, kUniformPdf, settings_.bounces,
                                                            sampler, rays, components.empty() ? nullptr : &lights);
            for (const PathLight& light : lights)
                addTo(components, light.component, light.radiance * (share / kUniformPdf), direction);
            gathered.add(emitter, sky, direction, in.radiance, in.firstHitBackFace);
        }
        gathered.end(estimate);
    }

    static void addTo(Components components, int component, vec3 light, vec3 direction)
    {
        if (components.empty() || light == vec3(0.0f)) return;
        SphericalHarmonicsL2& sum = components[std::size_t(component)];
        for (int i = 0; i < 9; ++i) sum[std::size_t(i)] += light * shading::shBasis(i, direction);
    }

    /// Light of the lights that are fully baked.
    void addBakedLights(uint32_t id, vec3 position, ProbeEstimate& estimate, Components components,
                        uint64_t& rays) const
    {
        std::vector<uint32_t> lights;
        std::vector<float> weights;
        paths_.light().forLightsNear(position, [&](const PunctualLight& light, uint32_t l) {
            if (!light.directAtProbes) return;
            const float weight = luminance(illuminanceOf(light, position));
            if (weight <= 0.0f) return;
            lights.push_back(l);
            weights.push_back(weight);
        });
        const float u = unitFloat(hashCombine(settings_.seed ^ kShadowSeed, id));
        shareRays(weights, shadowSamples(), kLightsWithOwnRays, u, [&](std::size_t i, int count, float scale) {
            addBakedLight(lights[i], count, scale, id, position, estimate, components, rays);
        });
    }

    /// From all directions, without shadows; of an area light about that.
    static vec3 illuminanceOf(const PunctualLight& light, vec3 position)
    {
        if (!light.isArea()) return light.at(position).illuminance;
        return light.reaches(position) ? light.radianceAt(position) * light.roughSolidAngle(position) : vec3(0.0f);
    }

    /// A light without a size is a delta distribution of directions: its coefficients are illuminance times basis
    /// functions. Of an area light they are those of its samples.
    void addBakedLight(uint32_t index, int count, float scale, uint32_t id, vec3 position, ProbeEstimate& estimate,
                       Components components, uint64_t& rays) const
    {
        const PunctualLight& light = paths_.light().lights()[index];
        const auto add = [&](vec3 illuminance, vec3 direction) {
            for (int i = 0; i < 9; ++i)
                estimate.radiance[std::size_t(i)] += illuminance * shading::shBasis(i, direction);
            addTo(components, light.component, illuminance, direction);
        };
        if (!light.isArea()) {
            const shading::LightSample sample = light.at(position);
            const vec3 visible = visibility(light, index, count, id, position, rays);
            add(sample.illuminance * (scale * shadowOf(light, visible)), sample.direction);
            return;
        }
        const vec3 radiance = light.radianceAt(position) * (scale / float(count));
        forLightRays(light, index, count, id, position, rays, [&](const LightRay& ray, vec3 visible) {
            add(radiance * (ray.solidAngle * shadowOf(light, visible)), ray.direction);
        });
    }

    [[nodiscard]] int shadowSamples() const { return std::max(settings_.shadowSamples, 16); }

    /// Calls visit(ray, visibility) for each of `count` shadow rays to the light.
    template<typename Visit> void forLightRays(const PunctualLight& light, uint32_t lightIndex, int count, uint32_t id,
                                               vec3 position, uint64_t& rays, const Visit& visit) const
    {
        for (int s = 0; s < count; ++s) {
            Sampler sampler(settings_.seed ^ kShadowSeed, hashCombine(~id, lightIndex), uint32_t(s));
            const LightRay ray = sampleLightRay(light, position, shading::sampleDisc(sampler.next2()));
            if (light.isArea() && ray.solidAngle <= 0.0f) continue;
            visit(ray, paths_.direct().lightVisibilityInSpace(light, position, ray, rays));
        }
    }

    /// Share of the light that arrives; of an area light, of its illuminance from all directions together.
    vec3 visibility(const PunctualLight& light, uint32_t lightIndex, int count, uint32_t id, vec3 position,
                    uint64_t& rays) const
    {
        vec3 sum(0.0f);
        float all = 0.0f;
        forLightRays(light, lightIndex, count, id, position, rays, [&](const LightRay& ray, vec3 visible) {
            const float weight = light.isArea() ? ray.solidAngle : 1.0f;
            sum += weight * visible;
            all += weight;
        });
        return all > 0.0f ? sum / all : vec3(1.0f);
    }

    const PathTracer& paths_;
    const IntegrationSettings& settings_;
    int samples_;
};

} // namespace

std::vector<vec3> besideProbes(const RayTracer& surfaces, std::span<const vec3> positions)
{
    constexpr float kEpsilons = 4.0f;             // so that it is more than one in each direction
    const vec3 direction = {0.36f, 0.80f, 0.48f}; // along no plane that scenes are built of; up, off a floor
    std::vector<vec3> beside(positions.size());
    for (std::size_t i = 0; i < beside.size(); ++i)
        beside[i] = positions[i] + kEpsilons * surfaces.epsilonAt(positions[i]) * direction;
    return beside;
}

Status traceProbesOn(const DevicePaths& device, const PathTracer& paths, const IntegrationSettings& settings,
                     std::span<const vec3> positions, std::span<const uint32_t> which, int samples,
                     std::span<ProbeEstimate> out, std::span<SphericalHarmonicsL2> components, const Progress& progress,
                     std::atomic<uint64_t>& rays)
{
    const std::size_t ofProbe = components.empty() ? 0 : std::size_t(paths.light().components());
    std::ranges::fill(components, SphericalHarmonicsL2{});
    const ProbeTracer tracer(paths, settings, samples > 0 ? samples : settings.probeSamples);
    const std::size_t most = DevicePaths::itemsOfCall(tracer.samples(), int(ofProbe));
    const std::size_t calls = (which.size() + most - 1) / most;
    parallelFor(calls, 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t call = begin; call < end; ++call) {
            if (progress.cancelled() || paths.surfaces().failed()) return;
            const std::size_t first = call * most;
            const std::size_t count = std::min(most, which.size() - first);
            uint64_t traced = 0;
            if (Status s = tracer.gatherOn(device, positions, which.subspan(first, count), out.subspan(first, count),
                                           components.subspan(first * ofProbe, count * ofProbe), traced);
                !s)
                paths.surfaces().keep(s.error());
            rays += traced;
        }
    });
    const bool finished = parallelFor(which.size(), 1, progress, "probes", [&](std::size_t begin, std::size_t end) {
        uint64_t traced = 0;
        for (std::size_t i = begin; i < end; ++i)
            tracer.addLights(which[i], positions[which[i]], out[i], components.subspan(i * ofProbe, ofProbe), traced);
        rays += traced;
    });
    return paths.surfaces().outcome(finished);
}

Status traceProbes(const PathTracer& paths, const IntegrationSettings& settings, std::span<const vec3> positions,
                   std::span<const uint32_t> which, int samples, std::span<ProbeEstimate> out,
                   std::span<SphericalHarmonicsL2> components, const Progress& progress, std::atomic<uint64_t>& rays)
{
    const std::size_t count = components.empty() ? 0 : std::size_t(paths.light().components());
    std::ranges::fill(components, SphericalHarmonicsL2{});
    const ProbeTracer tracer(paths, settings, samples > 0 ? samples : settings.probeSamples);
    const bool finished = parallelFor(which.size(), 1, progress, "probes", [&](std::size_t begin, std::size_t end) {
        uint64_t traced = 0;
        for (std::size_t i = begin; i < end; ++i)
            out[i] = tracer.trace(which[i], positions[which[i]], components.subspan(i * count, count), traced);
        rays += traced;
    });
    return paths.surfaces().outcome(finished);
}

} // namespace halflight
