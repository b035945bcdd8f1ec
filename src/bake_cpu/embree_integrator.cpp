#include "halflight/bake_cpu/embree_integrator.h"

#include "bake_cpu/lightmap/cached_lightmap.h"
#include "bake_cpu/sample/path_tracer.h"
#include "bake_cpu/shadows/baked_lights.h"
#include "bake_cpu/shadows/shadow_pass.h"
#include "bake_cpu/texels/texel_set.h"
#include "bake_cpu/texels/texel_validity.h"

#include "halflight/base/finite.h"
#include "halflight/base/parallel.h"
#include "halflight/shading/sampling.h"
#include "halflight/shading/sh.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

namespace halflight {
namespace {

constexpr std::size_t kTexelGrain = 64;
constexpr uint32_t kShadowSeed = 0x5eed0001u;
constexpr uint32_t kDirectSeed = 0x5eed0002u;
constexpr uint32_t kProbeSeed = 0x5eed0003u;
/// Masks are stored in steps of a 255th, and multiply light; light itself is stored as it is.
constexpr int kTimesOnMaskEdges = 2;
constexpr int kTimesOnLightEdges = 8;

/// Mean, first moment and variance of the mean of a stream of irradiance samples.
struct Accumulator {
    vec3 sum{0.0f};
    vec3 momentSum{0.0f};
    double luminanceSum = 0.0;
    double luminanceSquares = 0.0;
    int count = 0;

    void add(vec3 value)
    {
        sum += value;
        const double l = luminance(value);
        luminanceSum += l;
        luminanceSquares += l * l;
        ++count;
    }
    /// Counts a value's direction, beside add().
    void addDirection(vec3 value, vec3 direction) { momentSum += luminance(value) * direction; }
    [[nodiscard]] vec3 mean() const { return count > 0 ? sum / float(count) : vec3(0.0f); }
    [[nodiscard]] vec3 moment() const { return count > 0 ? momentSum / float(count) : vec3(0.0f); }
    [[nodiscard]] float varianceOfMean() const
    {
        if (count < 2) return 0.0f;
        const double m = luminanceSum / count;
        return float(std::max(0.0, luminanceSquares / count - m * m) / (count - 1));
    }
};

class EmbreeIntegrator final : public Integrator {
public:
    EmbreeIntegrator(const Scene& scene, const BakeGeometry& geometry, const IntegrationSettings& settings)
        : geometry_(geometry), settings_(settings), paths_(scene, geometry, LightUse::Bake), validity_(paths_),
          pattern_(settings.seed), lightmap_(paths_, pattern_, settings)
    {}

    [[nodiscard]] bool ok() const { return paths_.ok(); }

    [[nodiscard]] std::string description() const override
    {
        const char* kind = settings_.integrator == IntegratorKind::Cache ? "radiance cache" : "path tracing";
        return "cpu (" + std::string(kind) + ", Embree " + RTC_VERSION_STRING + ", " + std::to_string(threadCount()) +
               (threadCount() == 1 ? " thread)" : " threads)");
    }

    [[nodiscard]] uint64_t raysTraced() const override { return rays_.load(); }

    bool irradiance(const TexelMap& map, const TexelRequest& request, std::span<IrradianceEstimate> out,
                    const Progress& progress) override
    {
        const Effort effort = effortOf(request);
        if (settings_.integrator == IntegratorKind::Cache) {
            return lightmap_.irradiance(map, request.texels, effort.samples, out, progress, rays_) &&
                   addBakedLights(map, request, effort, out, progress);
        }
        return parallelFor(request.texels.size(), kTexelGrain, progress, "lightmap",
                           [&](std::size_t begin, std::size_t end) {
                               uint64_t rays = 0;
                               for (std::size_t i = begin; i < end && !progress.cancelled(); ++i)
                                   out[i] = texelIrradiance(map, map.texels[request.texels[i]], effort.samples, rays);
                               rays_ += rays;
                           }) &&
               addBakedLights(map, request, effort, out, progress);
    }

    void releaseIrradiance() override { lightmap_.release(); }

    bool shadowmask(const TexelMap& map, const TexelRequest& request, std::span<const IrradianceEstimate> estimates,
                    std::span<vec4> out, const Progress& progress) override
    {
        std::fill(out.begin(), out.end(), vec4(1.0f));
        // Lights that share a channel do not reach the same places.
        std::vector<ShadowSource> sources;
        std::vector<int> channels;
        int timesOnEdges = kTimesOnMaskEdges;
        for (int channel = 0; channel < 4; ++channel) {
            std::vector<const PunctualLight*> owners;
            for (const PunctualLight& light : paths_.lights()) {
                if (light.channel == channel) owners.push_back(&light);
            }
            if (owners.empty()) continue;
            channels.push_back(channel);
            const bool ofLight = owners.front()->maskOfLight;
            if (ofLight) timesOnEdges = kTimesOnLightEdges;
            sources.push_back(
                {LightReach(owners), ofLight, hashCombine(settings_.seed ^ kShadowSeed, uint32_t(channel))});
        }
        std::vector<LitCount> counts;
        if (!traceShadows({paths_, pattern_, map, gridOf(map), request.texels, masksOf(request, estimates),
                           effortOf(request).shadowSamples, timesOnEdges, progress, "shadowmask", rays_},
                          sources, counts)) {
            return false;
        }
        for (std::size_t i = 0; i < request.texels.size(); ++i) {
            for (std::size_t c = 0; c < channels.size(); ++c) {
                const LitCount& count = counts[i * channels.size() + c];
                // Nothing arrives where there would be no light without shadows either.
                out[i][channels[c]] = sources[c].lit && !count.any() ? 0.0f : count.share();
            }
        }
        return true;
    }

    bool probes(std::span<const vec3> positions, std::span<const uint32_t> which, int samples,
                std::span<ProbeEstimate> out, const Progress& progress) override
    {
        if (samples <= 0) samples = settings_.probeSamples;
        return parallelFor(which.size(), 1, progress, "probes", [&](std::size_t begin, std::size_t end) {
            uint64_t rays = 0;
            for (std::size_t i = begin; i < end; ++i) out[i] = probe(which[i], positions[which[i]], samples, rays);
            rays_ += rays;
        });
    }

    [[nodiscard]] std::optional<vec2> surfacesBetween(vec3 from, vec3 to) const override
    {
        const float length = glm::distance(from, to);
        if (!(length > 0.0f)) return std::nullopt;
        const vec3 direction = (to - from) / length;
        const RayHit first = paths_.surfaces().nearest(from, direction, 0.0f, length);
        if (!first.found) return std::nullopt;
        const RayHit last = paths_.surfaces().nearest(to, -direction, 0.0f, length);
        return vec2(first.distance, last.found ? length - last.distance : first.distance);
    }

private:
    struct Effort {
        int samples;
        int shadowSamples;
    };

    [[nodiscard]] Effort effortOf(const TexelRequest& request) const
    {
        return {request.samples > 0 ? request.samples : settings_.samples,
                request.shadowSamples > 0 ? request.shadowSamples : settings_.shadowSamples};
    }

    /// Points that irradiance() found inside solids must not darken what shadow rays find.
    static std::vector<PointMask> masksOf(const TexelRequest& request, std::span<const IrradianceEstimate> estimates)
    {
        std::vector<PointMask> masks(request.texels.size(), kAllPoints);
        for (std::size_t i = 0; i < estimates.size(); ++i)
            masks[i] = estimates[i].valid ? PointMask(estimates[i].outsidePoints) : PointMask(0);
        return masks;
    }

    const TexelGrid& gridOf(const TexelMap& map)
    {
        if (grid_ == nullptr || gridMap_ != &map || gridTexels_ != map.texels.size()) {
            grid_ = std::make_unique<TexelGrid>(map);
            gridMap_ = &map;
            gridTexels_ = map.texels.size();
        }
        return *grid_;
    }

    bool addBakedLights(const TexelMap& map, const TexelRequest& request, const Effort& effort,
                        std::span<IrradianceEstimate> out, const Progress& progress)
    {
        const std::vector<PointMask> masks = masksOf(request, out);
        return halflight::addBakedLights({paths_, pattern_, map, gridOf(map), request.texels, masks,
                                          effort.shadowSamples, kTimesOnLightEdges, progress, "lights", rays_},
                                         settings_.seed ^ kDirectSeed, out);
    }

    IrradianceEstimate texelIrradiance(const TexelMap& map, const Texel& texel, int samples, uint64_t& rays) const
    {
        TexelPoints points;
        int pointCount = texelPoints(geometry_, map, texel, points);
        const uint32_t id = texelId(map, texel);

        const PointMask mask = validity_.outside(points, pointCount, id, rays);
        TexelValidity::keep(mask, points, pointCount);
        IrradianceEstimate estimate;
        estimate.valid = mask != 0;
        estimate.outsidePoints = mask;
        if (!estimate.valid) return estimate;
        const Accumulator gathered = gather(points, pointCount, samples, id, rays);
        estimate.irradiance = gathered.mean();
        estimate.moment = gathered.moment();
        estimate.varianceOfMean = gathered.varianceOfMean();
        estimate.samples = uint32_t(gathered.count);

        return estimate;
    }

    // Irradiance is pi times the mean of cosine-distributed radiance (pdf cos / pi), plus what sampling the emitters
    // adds.
    Accumulator gather(const TexelPoints& points, int pointCount, int samples, uint32_t id, uint64_t& rays) const
    {
        Accumulator gathered;
        for (int s = 0; s < samples; ++s) {
            const SurfacePoint& point = points[std::size_t(s % pointCount)];
            Sampler sampler(settings_.seed, id, uint32_t(s));
            const vec3 direction = PathTracer::gatherDirection(point, sampler.next2());
            const float pdf = PathTracer::gatherPdf(point.normal, direction);
            const PathTracer::EmitterAtSurface emitter = paths_.emitterIrradiance(point, 0.0f, sampler, rays);
            const PathTracer::Incoming in = paths_.incoming({paths_.rayOrigin(point), point.normal}, direction, pdf,
                                                            settings_.bounces, sampler, rays);
            const vec3 bounced = kPi * in.radiance;
            const vec3 value = emitter.irradiance + bounced;
            // Lights of extreme size or strength can leave the range of floats.
            const bool finite = isFinite(value);
            gathered.add(finite ? value : vec3(0.0f));
            if (!finite) continue;
            gathered.addDirection(emitter.irradiance, emitter.direction);
            gathered.addDirection(bounced, direction);
        }
        return gathered;
    }

    /// The light that owns a channel at a point, or null: lights that share a channel do not reach the same places.
    const PunctualLight* ownerOfChannel(int channel, vec3 position, uint32_t& index) const
    {
        for (std::size_t l = 0; l < paths_.lights().size(); ++l) {
            const PunctualLight& light = paths_.lights()[l];
            if (light.channel != channel) continue;
            index = uint32_t(l);
            if (light.reaches(position)) return &light;
        }
        return nullptr;
    }

    ProbeEstimate probe(uint32_t id, vec3 position, int samples, uint64_t& rays) const
    {
        ProbeEstimate estimate;
        std::array<vec3, 9> sum{};
        int backFaces = 0;
        Accumulator mean; // of incoming radiance
        constexpr float kUniformPdf = 1.0f / (4.0f * kPi);
        const auto add = [&](vec3 direction, vec3 weightedRadiance) {
            for (int i = 0; i < 9; ++i) sum[std::size_t(i)] += weightedRadiance * shading::shBasis(i, direction);
        };
        for (int s = 0; s < samples; ++s) {
            Sampler sampler(settings_.seed ^ kProbeSeed, id, uint32_t(s));
            const vec3 direction = shading::sampleSphere(sampler.next2());
            const PathTracer::EmitterInSpace emitter = paths_.emitterInSpace(position, kUniformPdf, sampler, rays);
            if (emitter.radianceOverPdf != vec3(0.0f)) add(emitter.direction, emitter.radianceOverPdf);
            const PathTracer::Incoming in =
                paths_.incoming({position}, direction, kUniformPdf, settings_.bounces, sampler, rays);
            backFaces += in.firstHitBackFace ? 1 : 0;
            add(direction, in.radiance / kUniformPdf);
            mean.add(in.radiance + emitter.radianceOverPdf * kUniformPdf);
        }
        for (int i = 0; i < 9; ++i) estimate.radiance[std::size_t(i)] = sum[std::size_t(i)] / float(samples);
        // A coefficient is 4 pi times the mean of radiance times a basis function, whose mean square is 1 / (4 pi).
        estimate.variance = 4.0f * kPi * mean.varianceOfMean();
        estimate.valid = backFaces * 4 < samples;

        // Fully baked lights are a delta in direction; a light's coefficient is its illuminance times the basis
        // function.
        for (std::size_t l = 0; l < paths_.lights().size(); ++l) {
            const PunctualLight& light = paths_.lights()[l];
            if (!light.directAtProbes) continue;
            const shading::LightSample sample = light.at(position);
            if (sample.illuminance == vec3(0.0f)) continue;
            const float visibility = probeVisibility(light, uint32_t(l), id, position, rays);
            const vec3 illuminance = sample.illuminance * glm::mix(1.0f, visibility, light.shadowStrength);
            for (int i = 0; i < 9; ++i)
                estimate.radiance[std::size_t(i)] += illuminance * shading::shBasis(i, sample.direction);
        }
        for (int channel = 0; channel < 4; ++channel) {
            uint32_t index = 0;
            if (const PunctualLight* light = ownerOfChannel(channel, position, index)) {
                estimate.occlusion[channel] = probeVisibility(*light, index, id, position, rays);
            }
        }
        return estimate;
    }

    float probeVisibility(const PunctualLight& light, uint32_t lightIndex, uint32_t id, vec3 position,
                          uint64_t& rays) const
    {
        const int samples = std::max(settings_.shadowSamples, 16);
        float sum = 0.0f;
        for (int s = 0; s < samples; ++s) {
            Sampler sampler(settings_.seed ^ kShadowSeed, hashCombine(~id, lightIndex), uint32_t(s));
            sum += paths_.lightVisibilityInSpace(light, position, sampler.next2(), rays);
        }
        return sum / float(samples);
    }

    const BakeGeometry& geometry_;
    IntegrationSettings settings_;
    PathTracer paths_;
    TexelValidity validity_;
    StratifiedPattern pattern_;
    CachedLightmap lightmap_;
    std::unique_ptr<TexelGrid> grid_; ///< of the map asked for last
    const TexelMap* gridMap_ = nullptr;
    std::size_t gridTexels_ = 0;
    std::atomic<uint64_t> rays_{0};
};

} // namespace

Result<std::unique_ptr<Integrator>> makeEmbreeIntegrator(const Scene& scene, const BakeGeometry& geometry,
                                                         const IntegrationSettings& settings)
{
    auto integrator = std::make_unique<EmbreeIntegrator>(scene, geometry, settings);
    if (!integrator->ok()) return Error{ErrorCode::DeviceFailed, "Embree could not build the scene (out of memory?)"};
    return std::unique_ptr<Integrator>(std::move(integrator));
}

} // namespace halflight
