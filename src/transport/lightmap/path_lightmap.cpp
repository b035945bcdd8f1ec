#include "transport/lightmap/path_lightmap.h"

#include "transport/sample/running_moments.h"

#include "halflight/base/finite.h"
#include "halflight/base/parallel.h"
#include "halflight/shading/sampling.h"

#include <algorithm>
#include <vector>

namespace halflight {
namespace {

/// Irradiance is pi times the mean radiance of cosine-distributed paths (pdf cos / pi), plus emitter samples.
RunningMoments gather(const PathTracer& paths, const IntegrationSettings& settings, const TexelPoints& points,
                      int pointCount, int samples, uint32_t id, std::span<RunningMoments> components, uint64_t& rays)
{
    RunningMoments gathered;
    PathLights lights;
    std::vector<RunningMoments> sample(components.size());
    for (int s = 0; s < samples; ++s) {
        const SurfacePoint& point = points[std::size_t(s % pointCount)];
        Sampler sampler(settings.seed, id, uint32_t(s));
        const vec3 direction = gatherDirection(point, sampler.next2());
        const float pdf = gatherPdf(point.normal, direction);
        const DirectLight::EmitterAtSurface emitter = paths.direct().emitterIrradiance(point, 0.0f, sampler, rays);
        const DirectLight::EmitterAtSurface sky = paths.direct().skyIrradiance(point, 0.0f, sampler, rays);
        const PathTracer::Incoming in =
            paths.incoming({paths.surfaces().rayOrigin(point), point.normal}, direction, pdf, settings.bounces, sampler,
                           rays, components.empty() ? nullptr : &lights);
        const vec3 bounced = kPi * in.radiance;
        const vec3 value = emitter.irradiance + sky.irradiance + bounced;
        // Lights of extreme size or intensity may overflow.
        const bool finite = isFinite(value);
        const vec3 moment = luminance(emitter.irradiance) * emitter.direction +
                            luminance(sky.irradiance) * sky.direction + luminance(bounced) * direction;
        gathered.add(finite ? value : vec3(0.0f), finite ? moment : vec3(0.0f));
        if (components.empty()) continue;
        std::ranges::fill(sample, RunningMoments{});
        const auto addTo = [&](int component, vec3 irradiance, vec3 from) {
            sample[std::size_t(component)].sum += irradiance;
            sample[std::size_t(component)].moment += luminance(irradiance) * from;
        };
        addTo(emitter.component, emitter.irradiance, emitter.direction);
        addTo(sky.component, sky.irradiance, sky.direction);
        for (const PathLight& light : lights) addTo(light.component, kPi * light.radiance, direction);
        lights.clear();
        for (std::size_t c = 0; c < components.size(); ++c)
            components[c].add(finite ? sample[c].sum : vec3(0.0f), finite ? sample[c].moment : vec3(0.0f));
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

} // namespace

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
        int pointCount = texelPoints(paths.surfaces().geometry(), map, texel, points);
        keepPoints(texel.validPoints, points, pointCount);
        spreadOverSides(paths.surfaces().geometry(), points, pointCount);
        const uint32_t id = texelId(map, texel);
        std::vector<RunningMoments> components(ofComponents.size());
        const auto take = [](const RunningMoments& from, IrradianceEstimate& to) {
            to.irradiance = from.mean();
            to.moment = from.meanMoment();
            to.varianceOfMean = from.varianceOfMean();
            to.samples = from.count;
        };
        take(gather(paths, settings, points, pointCount, samples, id, components, traced), estimate);
        for (std::size_t c = 0; c < components.size(); ++c) take(components[c], ofComponents[c]);
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
