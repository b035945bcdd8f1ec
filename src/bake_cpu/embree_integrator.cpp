#include "halflight/bake_cpu/embree_integrator.h"

#include "bake_cpu/path.h"

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
constexpr uint32_t kInsideSeed = 0x5eed0004u;
constexpr int kInsideRays = 4;

bool isFinite(vec3 v)
{
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

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
        : geometry_(geometry), settings_(settings), paths_(scene, geometry, LightUse::Bake),
          anySolid_(std::find(geometry.solid.begin(), geometry.solid.end(), uint8_t(1)) != geometry.solid.end())
    {}

    [[nodiscard]] bool ok() const { return paths_.ok(); }

    [[nodiscard]] std::string description() const override
    {
        return "cpu (Embree " + std::string(RTC_VERSION_STRING) + ", " + std::to_string(threadCount()) +
               (threadCount() == 1 ? " thread)" : " threads)");
    }

    [[nodiscard]] uint64_t raysTraced() const override { return rays_.load(); }

    bool irradiance(const TexelMap& map, const TexelRequest& request, std::span<IrradianceEstimate> out,
                    const Progress& progress) override
    {
        const Effort effort = effortOf(request);
        return parallelFor(request.texels.size(), kTexelGrain, progress, "lightmap",
                           [&](std::size_t begin, std::size_t end) {
                               uint64_t rays = 0;
                               for (std::size_t i = begin; i < end && !progress.cancelled(); ++i)
                                   out[i] = texelIrradiance(map, map.texels[request.texels[i]], effort, rays);
                               rays_ += rays;
                           });
    }

    bool shadowmask(const TexelMap& map, const TexelRequest& request, std::span<const IrradianceEstimate> estimates,
                    std::span<vec4> out, const Progress& progress) override
    {
        const Effort effort = effortOf(request);
        return parallelFor(
            request.texels.size(), kTexelGrain, progress, "shadowmask", [&](std::size_t begin, std::size_t end) {
                uint64_t rays = 0;
                for (std::size_t i = begin; i < end && !progress.cancelled(); ++i) {
                    // Points that irradiance() found inside solids must not darken the mask either.
                    const PointMask outside = estimates.empty()
                                                  ? kAllPoints
                                                  : (estimates[i].valid ? estimates[i].outsidePoints : PointMask(0));
                    out[i] = texelShadowmask(map, map.texels[request.texels[i]], outside, effort, rays);
                }
                rays_ += rays;
            });
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
        const SurfaceHit first = paths_.surfaces().intersect(from, direction, 0.0f, length);
        if (!first.found) return std::nullopt;
        const SurfaceHit last = paths_.surfaces().intersect(to, -direction, 0.0f, length);
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

    /// What seeds a texel's random numbers: its place, whatever else the bake covers.
    static uint32_t texelId(const TexelMap& map, const Texel& texel)
    {
        return (texel.page * uint32_t(map.pageSize) + texel.y) * uint32_t(map.pageSize) + texel.x;
    }

    /// Whether a point lies inside geometry: most of a few rays leave more closed objects than they enter, or all of
    /// them meet back faces first (single-sided shells that are not closed).
    bool inside(const SurfacePoint& point, uint32_t id, uint64_t& rays) const
    {
        const vec3 origin = paths_.rayOrigin(point);
        int insideSolids = 0;
        int backFaces = 0;
        for (int s = 0; s < kInsideRays; ++s) {
            const SurfaceTracer::Crossings crossings = crossingsFrom(point, origin, id, s, rays);
            insideSolids += crossings.solidsLeft > 0 ? 1 : 0;
            backFaces += crossings.backFaceFirst ? 1 : 0;
            // Two rays that agree are enough.
            if (s == 1 && insideSolids == 2) return true;
            if (s == 1 && insideSolids == 0 && backFaces < 2) return false;
        }
        return 2 * insideSolids > kInsideRays || backFaces == kInsideRays;
    }

    SurfaceTracer::Crossings crossingsFrom(const SurfacePoint& point, vec3 origin, uint32_t id, int sample,
                                           uint64_t& rays) const
    {
        Sampler sampler(settings_.seed ^ kInsideSeed, id, uint32_t(sample));
        const SurfaceTracer::Crossings crossings =
            paths_.surfaces().crossings(origin, PathTracer::gatherDirection(point, sampler.next2()));
        rays += uint64_t(crossings.rays);
        return crossings;
    }

    /// A first look with one ray from a few of the points: could some lie inside a solid?
    bool maybeInside(const std::array<SurfacePoint, kMaxTexelPoints>& points, int pointCount, uint32_t id,
                     uint64_t& rays) const
    {
        if (!anySolid_) return false;
        for (int i = 0; i < std::min(pointCount, 4); ++i) {
            const SurfacePoint& point = points[std::size_t(i * pointCount / std::min(pointCount, 4))];
            const SurfaceTracer::Crossings c = crossingsFrom(point, paths_.rayOrigin(point), id, i, rays);
            if (c.solidsLeft > 0 || c.backFaceFirst) return true;
        }
        return false;
    }

    using PointMask = uint16_t; ///< bit i: point i of a texel lies outside geometry; 0: (nearly) none does
    static_assert(kMaxTexelPoints <= 16);
    static constexpr PointMask kAllPoints = 0xffff;

    PointMask outsidePoints(const std::array<SurfacePoint, kMaxTexelPoints>& points, int pointCount, uint32_t id,
                            uint64_t& rays) const
    {
        PointMask mask = 0;
        int kept = 0;
        for (int p = 0; p < pointCount; ++p) {
            if (inside(points[std::size_t(p)], hashCombine(id, uint32_t(p)), rays)) continue;
            mask = PointMask(mask | (1u << p));
            ++kept;
        }
        return kept * 8 < pointCount ? PointMask(0) : mask;
    }

    /// Leaves only the points of the mask.
    static void keepPoints(PointMask mask, std::array<SurfacePoint, kMaxTexelPoints>& points, int& pointCount)
    {
        int kept = 0;
        for (int p = 0; p < pointCount; ++p) {
            if (mask & (1u << p)) points[std::size_t(kept++)] = points[std::size_t(p)];
        }
        pointCount = kept;
    }

    IrradianceEstimate texelIrradiance(const TexelMap& map, const Texel& texel, const Effort& effort,
                                       uint64_t& rays) const
    {
        std::array<SurfacePoint, kMaxTexelPoints> points;
        int pointCount = texelPoints(geometry_, map, texel, points);
        const uint32_t id = texelId(map, texel);

        // Points inside solids are left out, found beforehand where a few rays say so, or afterwards where the gathered
        // paths met many back faces.
        PointMask mask = kAllPoints;
        const bool checkedBefore = maybeInside(points, pointCount, id, rays);
        if (checkedBefore) {
            mask = outsidePoints(points, pointCount, id, rays);
            keepPoints(mask, points, pointCount);
        }
        int backFaces = 0;
        Accumulator gathered;
        if (mask != 0) gathered = gather(points, pointCount, effort.samples, id, rays, backFaces);
        if (mask != 0 && !checkedBefore && backFaces * 16 > gathered.count) {
            mask = outsidePoints(points, pointCount, id, rays);
            const int before = pointCount;
            keepPoints(mask, points, pointCount);
            if (mask != 0 && pointCount < before) {
                gathered = gather(points, pointCount, effort.samples, id, rays, backFaces);
            }
        }
        IrradianceEstimate estimate;
        estimate.valid = mask != 0;
        estimate.outsidePoints = mask;
        if (!estimate.valid) return estimate;
        estimate.irradiance = gathered.mean();
        estimate.moment = gathered.moment();
        estimate.varianceOfMean = gathered.varianceOfMean();

        for (std::size_t l = 0; l < paths_.lights().size(); ++l) {
            const PunctualLight& light = paths_.lights()[l];
            if (!light.directAtTexels) continue;
            const Accumulator direct =
                directIrradiance(light, uint32_t(l), points, pointCount, effort.shadowSamples, id, rays);
            estimate.irradiance += direct.mean();
            estimate.moment += direct.moment();
            estimate.varianceOfMean += direct.varianceOfMean();
        }
        return estimate;
    }

    // Irradiance is pi times the mean of cosine-distributed radiance (pdf cos / pi), plus what sampling the emitters
    // adds.
    Accumulator gather(const std::array<SurfacePoint, kMaxTexelPoints>& points, int pointCount, int samples,
                       uint32_t id, uint64_t& rays, int& backFaces) const
    {
        Accumulator gathered;
        for (int s = 0; s < samples; ++s) {
            const SurfacePoint& point = points[std::size_t(s % pointCount)];
            Sampler sampler(settings_.seed, id, uint32_t(s));
            const vec3 direction = PathTracer::gatherDirection(point, sampler.next2());
            const float pdf = std::max(glm::dot(direction, point.normal), 1.0e-4f) / kPi;
            const PathTracer::EmitterAtSurface emitter = paths_.emitterIrradiance(point, sampler, rays);
            const PathTracer::Incoming in =
                paths_.incoming(paths_.rayOrigin(point), direction, pdf, settings_.bounces, sampler, rays);
            backFaces += in.firstHitBackFace ? 1 : 0;
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

    Accumulator directIrradiance(const PunctualLight& light, uint32_t lightIndex,
                                 const std::array<SurfacePoint, kMaxTexelPoints>& points, int pointCount, int samples,
                                 uint32_t id, uint64_t& rays) const
    {
        Accumulator direct;
        for (int s = 0; s < samples; ++s) {
            const SurfacePoint& point = points[std::size_t(s % pointCount)];
            const shading::LightSample sample = light.at(point.position);
            const float cosine = glm::dot(point.normal, sample.direction);
            if (cosine <= 0.0f || sample.illuminance == vec3(0.0f)) {
                direct.add(vec3(0.0f));
                continue;
            }
            Sampler sampler(settings_.seed ^ kDirectSeed, hashCombine(id, lightIndex), uint32_t(s));
            const float visibility = paths_.lightVisibility(light, point, sampler.next2(), rays);
            const vec3 value = sample.illuminance * (cosine * glm::mix(1.0f, visibility, light.shadowStrength));
            direct.add(value);
            direct.addDirection(value, sample.direction);
        }
        return direct;
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

    vec4 texelShadowmask(const TexelMap& map, const Texel& texel, PointMask outside, const Effort& effort,
                         uint64_t& rays) const
    {
        std::array<SurfacePoint, kMaxTexelPoints> points;
        int pointCount = texelPoints(geometry_, map, texel, points);
        const uint32_t id = texelId(map, texel);
        if (outside == 0) return vec4(1.0f); // inside geometry: the bake fills it from texels around it
        keepPoints(outside, points, pointCount);
        vec4 mask(1.0f);
        for (int channel = 0; channel < 4; ++channel) {
            float sum = 0.0f;
            int count = 0;
            for (int s = 0; s < effort.shadowSamples; ++s) {
                const SurfacePoint& point = points[std::size_t(s % pointCount)];
                uint32_t index = 0;
                const PunctualLight* light = ownerOfChannel(channel, point.position, index);
                if (light == nullptr) continue;
                Sampler sampler(settings_.seed ^ kShadowSeed, hashCombine(id, index), uint32_t(s));
                sum += paths_.lightVisibility(*light, point, sampler.next2(), rays);
                ++count;
            }
            if (count > 0) mask[channel] = sum / float(count);
        }
        return mask;
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
                paths_.incoming(position, direction, kUniformPdf, settings_.bounces, sampler, rays);
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
    bool anySolid_ = false;
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
