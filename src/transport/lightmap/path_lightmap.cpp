#include "transport/lightmap/path_lightmap.h"

#include "transport/sample/running_moments.h"
#include "transport/trace/device_paths.h"

#include "halflight/base/finite.h"
#include "halflight/base/parallel.h"
#include "halflight/shading/sampling.h"

#include <algorithm>
#include <vector>

namespace halflight {
namespace {

using FromEmission = DirectLight::EmitterAtSurface;

/// Adds what one path and the samples at its start bring. False: lights of extreme size or intensity overflow, and the
/// sample counts as black. `direction`: where `bounced` light comes from.
bool addSample(const FromEmission& emitter, const FromEmission& sky, vec3 bounced, vec3 direction, RunningMoments& to)
{
    const vec3 value = emitter.irradiance + sky.irradiance + bounced;
    const bool finite = isFinite(value);
    const vec3 moment = luminance(emitter.irradiance) * emitter.direction + luminance(sky.irradiance) * sky.direction +
                        luminance(bounced) * direction;
    to.add(finite ? value : vec3(0.0f), finite ? moment : vec3(0.0f));
    return finite;
}

/// What one sample brings by component.
class SampleParts {
public:
    explicit SampleParts(std::size_t components) : parts_(components) {}

    void add(int component, vec3 irradiance, vec3 from)
    {
        parts_[std::size_t(component)].sum += irradiance;
        parts_[std::size_t(component)].moment += luminance(irradiance) * from;
    }
    /// Adds the sample to the estimates of components; as black where it is not `finite`. The next one begins.
    void end(bool finite, std::span<RunningMoments> components)
    {
        for (std::size_t c = 0; c < parts_.size(); ++c)
            components[c].add(finite ? parts_[c].sum : vec3(0.0f), finite ? parts_[c].moment : vec3(0.0f));
        std::ranges::fill(parts_, RunningMoments{});
    }

private:
    std::vector<RunningMoments> parts_; ///< sums
};

/// Irradiance is pi times the mean radiance of cosine-distributed paths (pdf cos / pi), plus emitter samples.
RunningMoments gather(const PathTracer& paths, const IntegrationSettings& settings, const TexelPoints& points,
                      int pointCount, int samples, uint32_t id, std::span<RunningMoments> components, uint64_t& rays)
{
    RunningMoments gathered;
    PathLights lights;
    SampleParts parts(components.size());
    for (int s = 0; s < samples; ++s) {
        const SurfacePoint& point = points[std::size_t(s % pointCount)];
        Sampler sampler(settings.seed, id, uint32_t(s));
        const vec3 direction = gatherDirection(point, sampler.next2());
        const float pdf = gatherPdf(point.normal, direction);
        const FromEmission emitter = paths.direct().emitterIrradiance(point, 0.0f, sampler, rays);
        const FromEmission sky = paths.direct().skyIrradiance(point, 0.0f, sampler, rays);
        const PathTracer::Incoming in =
            paths.incoming({paths.surfaces().rayOrigin(point), point.normal}, direction, pdf, settings.bounces, sampler,
                           rays, components.empty() ? nullptr : &lights);
        const vec3 bounced = kPi * in.radiance;
        const bool finite = addSample(emitter, sky, bounced, direction, gathered);
        if (components.empty()) continue;
        parts.add(emitter.component, emitter.irradiance, emitter.direction);
        parts.add(sky.component, sky.irradiance, sky.direction);
        for (const PathLight& light : lights) parts.add(light.component, kPi * light.radiance, direction);
        lights.clear();
        parts.end(finite, components);
    }
    return gathered;
}

/// Direct light at a point, with one shadow ray.
vec3 lightAt(const PathTracer& paths, const PunctualLight& light, const SurfacePoint& point, Sampler& sampler,
             uint64_t& rays)
{
    const vec3 direct = light.irradianceAt(point.position, point.normal);
    if (direct == vec3(0.0f)) return direct;
    const vec2 disc = shading::sampleDisc(sampler.next2());
    return direct * shadowOf(light, paths.direct().lightVisibility(light, point, disc, rays));
}

/// Whether a random walk from a point leaves the scene, meets a surface that emits, or comes in sight of an eye.
bool walkGetsOut(const PathTracer& paths, SurfacePoint point, std::span<const vec3> eyes, Sampler& sampler,
                 uint64_t& rays)
{
    constexpr int kMostSteps = 16; // through a room whose opening is a twentieth of its walls, a walk gets out in half
    const RayTracer& surfaces = paths.surfaces();
    for (int step = 0; step < kMostSteps; ++step) {
        const vec3 origin = paths.surfaces().rayOrigin(point);
        if (!eyes.empty()) {
            const auto eye = std::min(std::size_t(sampler.next1() * float(eyes.size())), eyes.size() - 1);
            const vec3 way = eyes[eye] - origin;
            const float distance = glm::length(way);
            if (glm::dot(way, point.geometricNormal) > 0.0f) {
                ++rays;
                if (!surfaces.occluded(origin, way / distance, 0.0f, distance)) return true;
            }
        }
        ++rays;
        const RayHit hit = surfaces.nearest(origin, gatherDirection(point, sampler.next2()), 0.0f, kInfinity);
        if (!hit.found()) return true;
        if (surfaces.hitHiddenBack(hit)) return false; // inside a solid or a shell
        const SurfaceHit surface = surfaces.surfaceAt(hit);
        if (surface.emission != vec3(0.0f)) return true;
        point = surface.point;
    }
    return false;
}

/// The valid points of a texel, from which paths start.
int startsOf(const PathTracer& paths, const TexelMap& map, const Texel& texel, TexelPoints& points)
{
    const BakeGeometry& geometry = paths.surfaces().geometry();
    int count = texelPoints(geometry, map, texel, points);
    keepPoints(texel.validPoints, points, count);
    spreadOverSides(geometry, points, count);
    return count;
}

IrradianceEstimate meansOf(const RunningMoments& from)
{
    IrradianceEstimate estimate;
    estimate.irradiance = from.mean();
    estimate.moment = from.meanMoment();
    estimate.varianceOfMean = from.varianceOfMean();
    estimate.samples = from.count;
    return estimate;
}

/// Texels whose paths a device traces in one call, or in several where each has many.
class TexelsOnDevice {
public:
    TexelsOnDevice(const PathTracer& paths, const TexelMap& map, std::span<const uint32_t> texels,
                   std::size_t components)
        : map_(map), texels_(texels), moments_(texels.size() + 1), skyComponent_(paths.light().skyComponent()),
          components_(components), ofComponents_((texels.size() + 1) * components)
    {
        TexelPoints points;
        for (const uint32_t texel : texels) {
            if (map.texels[texel].validPoints == 0) continue;
            const int count = startsOf(paths, map, map.texels[texel], points);
            items_.push_back({texelId(map, map.texels[texel]), uint32_t(points_.size()), uint32_t(count)});
            for (const SurfacePoint& p : std::span(points).first(std::size_t(count)))
                points_.push_back({p.position, p.normal, p.geometricNormal});
        }
    }

    Status trace(const DevicePaths& device, uint32_t seed, uint32_t samples, uint64_t& rays)
    {
        SampleParts parts(components_);
        const auto take = [&](std::size_t item, const DevicePaths::Arrival& a, const DevicePaths::Emission& e,
                              std::span<const vec3> components) {
            const bool finite = addSample({e.toEmitter, e.ofEmitter}, {e.toSky, e.ofSky}, kPi * a.radiance, a.direction,
                                          moments_[item]);
            rays += a.rays;
            if (components.empty()) return;
            parts.add(a.emitterComponent, e.ofEmitter, e.toEmitter);
            parts.add(skyComponent_, e.ofSky, e.toSky);
            for (std::size_t c = 0; c < components_; ++c) parts.add(int(c), kPi * components[c], a.direction);
            parts.end(finite, std::span(ofComponents_).subspan(item * components_, components_));
        };
        return device.traceAll(points_, items_, seed, samples, int(components_), take);
    }

    /// `out`: of these texels.
    void write(const TexelLight& out) const
    {
        std::size_t item = 0;
        for (std::size_t i = 0; i < texels_.size(); ++i) {
            const bool valid = map_.texels[texels_[i]].validPoints != 0;
            const auto estimateOf = [valid](const RunningMoments& from) {
                IrradianceEstimate estimate = valid ? meansOf(from) : IrradianceEstimate();
                estimate.valid = valid;
                return estimate;
            };
            out.texels[i] = estimateOf(moments_[item]);
            for (std::size_t c = 0; c < components_; ++c)
                out.components[i * components_ + c] = estimateOf(ofComponents_[item * components_ + c]);
            item += valid ? 1 : 0;
        }
    }

private:
    const TexelMap& map_;
    std::span<const uint32_t> texels_;
    std::vector<DevicePaths::Point> points_;
    std::vector<DevicePaths::Item> items_; ///< of valid texels
    std::vector<RunningMoments> moments_;  ///< by item, and one more: invalid texels at the end read it
    int skyComponent_;
    std::size_t components_;                   ///< 0: none are asked for
    std::vector<RunningMoments> ofComponents_; ///< by item and component
};

} // namespace

Status tracePathLightmapOn(const DevicePaths& device, const PathTracer& paths, const IntegrationSettings& settings,
                           const TexelMap& map, std::span<const uint32_t> texels, int samples, const TexelLight& out,
                           const Progress& progress, std::atomic<uint64_t>& rays)
{
    const std::size_t components = out.components.empty() ? 0 : std::size_t(paths.light().components());
    const std::size_t most = DevicePaths::itemsOfCall(samples, int(components));
    const std::size_t calls = (texels.size() + most - 1) / most;
    const bool finished = parallelFor(calls, 1, progress, "lightmap", [&](std::size_t begin, std::size_t end) {
        for (std::size_t call = begin; call < end; ++call) {
            if (progress.cancelled() || paths.surfaces().failed()) return;
            const std::size_t first = call * most;
            const std::size_t count = std::min(most, texels.size() - first);
            uint64_t traced = 0;
            TexelsOnDevice some(paths, map, texels.subspan(first, count), components);
            if (Status s = some.trace(device, settings.seed, uint32_t(samples), traced); !s)
                paths.surfaces().keep(s.error());
            some.write(
                {out.texels.subspan(first, count), out.components.subspan(first * components, count * components)});
            rays += traced;
        }
    });
    return paths.surfaces().outcome(finished);
}

Status tracePathLightmap(const PathTracer& paths, const IntegrationSettings& settings, const TexelMap& map,
                         std::span<const uint32_t> texels, int samples, const TexelLight& out, const Progress& progress,
                         std::atomic<uint64_t>& rays)
{
    constexpr std::size_t kTexelGrain = 64;
    const std::size_t count = out.components.empty() ? 0 : std::size_t(paths.light().components());
    const auto estimateOf = [&](const Texel& texel, std::span<IrradianceEstimate> ofComponents, uint64_t& traced) {
        IrradianceEstimate estimate;
        estimate.valid = texel.validPoints != 0;
        std::ranges::fill(ofComponents, estimate);
        if (!estimate.valid) return estimate;
        TexelPoints points;
        const int pointCount = startsOf(paths, map, texel, points);
        const uint32_t id = texelId(map, texel);
        std::vector<RunningMoments> components(ofComponents.size());
        estimate = meansOf(gather(paths, settings, points, pointCount, samples, id, components, traced));
        for (std::size_t c = 0; c < components.size(); ++c) ofComponents[c] = meansOf(components[c]);
        return estimate;
    };
    const bool finished =
        parallelFor(texels.size(), kTexelGrain, progress, "lightmap", [&](std::size_t begin, std::size_t end) {
            uint64_t traced = 0;
            for (std::size_t i = begin; i < end && !progress.cancelled(); ++i)
                out.texels[i] = estimateOf(map.texels[texels[i]], out.components.subspan(i * count, count), traced);
            rays += traced;
        });
    return paths.surfaces().outcome(finished);
}

Status traceRoughLightmap(const PathTracer& paths, const IntegrationSettings& settings, const TexelMap& map,
                          std::span<const uint32_t> texels, int samples, std::span<IrradianceEstimate> out,
                          const Progress& progress, std::atomic<uint64_t>& rays)
{
    if (Status s = tracePathLightmap(paths, settings, map, texels, samples, {out, {}}, progress, rays); !s) return s;
    constexpr std::size_t kTexelGrain = 64;
    const bool finished =
        parallelFor(texels.size(), kTexelGrain, progress, "lights", [&](std::size_t begin, std::size_t end) {
            uint64_t traced = 0;
            TexelPoints points;
            for (std::size_t i = begin; i < end && !progress.cancelled(); ++i) {
                const Texel& texel = map.texels[texels[i]];
                const int count = texelPoints(paths.surfaces().geometry(), map, texel, points);
                spreadOverSides(paths.surfaces().geometry(), points, count);
                Sampler sampler(settings.seed, texelId(map, texel), uint32_t(samples)); // beyond the paths' own
                const SurfacePoint& point =
                    points[std::size_t(std::min(int(sampler.next1() * float(count)), count - 1))];
                paths.light().forLightsNear(point.position, [&](const PunctualLight& light, uint32_t) {
                    if (light.directAtTexels) out[i].irradiance += lightAt(paths, light, point, sampler, traced);
                });
            }
            rays += traced;
        });
    return paths.surfaces().outcome(finished);
}

Status traceSides(const PathTracer& paths, const IntegrationSettings& settings, std::span<const SurfacePoint> points,
                  std::span<const vec3> eyes, int samples, int walks, std::span<SideEstimate> out,
                  const Progress& progress, std::atomic<uint64_t>& rays)
{
    constexpr uint32_t kSidesSeed = 0x5eed0051u;
    constexpr std::size_t kGrain = 16;
    IntegrationSettings own = settings;
    own.seed = settings.seed ^ kSidesSeed;
    const bool finished =
        parallelFor(points.size(), kGrain, progress, "sheets", [&](std::size_t begin, std::size_t end) {
            uint64_t traced = 0;
            TexelPoints one;
            for (std::size_t i = begin; i < end && !progress.cancelled(); ++i) {
                const uint32_t id = uint32_t(i);
                Sampler sampler(own.seed, id, uint32_t(samples)); // beyond the paths' own
                SideEstimate& side = out[i] = {};
                for (int walk = 0; walk < walks; ++walk) {
                    Sampler ofWalk(own.seed, id, uint32_t(samples + 1 + walk));
                    side.open += walkGetsOut(paths, points[i], eyes, ofWalk, traced) ? 1.0f / float(walks) : 0.0f;
                }
                if (samples == 0) continue;
                one[0] = points[i];
                side.irradiance = gather(paths, own, one, 1, samples, id, {}, traced).mean();
                paths.light().forLightsNear(points[i].position, [&](const PunctualLight& light, uint32_t) {
                    vec3& sum = light.directAtTexels || light.maskOfLight ? side.irradiance : side.direct;
                    sum += lightAt(paths, light, points[i], sampler, traced);
                });
            }
            rays += traced;
        });
    return paths.surfaces().outcome(finished);
}

} // namespace halflight
