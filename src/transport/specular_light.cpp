// What surfaces reflect by their specular lobes: the truth that reflection probes are judged by.

#include "transport/reflections.h"

#include "halflight/base/parallel.h"
#include "halflight/shading/brdf_sampling.h"

#include <algorithm>

namespace halflight {
namespace {

constexpr uint32_t kSpecularSeed = 0x5eed0009u;
/// Paths per point and view. Judgements are sums over many points, where their noise averages out.
constexpr int kPaths = 12;

class SpecularTracer {
public:
    SpecularTracer(const PathTracer& paths, const IntegrationSettings& settings) : paths_(paths), settings_(settings) {}

    SpecularEstimate at(const SurfacePoint& point, std::span<const vec3> views, uint32_t index, uint64_t& rays) const
    {
        const SurfaceReflectance surface =
            paths_.surfaces().materials().reflectanceAt(point.triangle, point.barycentric);
        SpecularEstimate result{surface.baseColor, surface.metallic, surface.roughness, surface.specular, {}};
        for (std::size_t v = 0; v < views.size(); ++v) {
            vec3 sum(0.0f);
            for (int s = 0; s < kPaths; ++s) {
                Sampler sampler(settings_.seed ^ kSpecularSeed, index, uint32_t(v) * uint32_t(kPaths) + uint32_t(s));
                sum += reflected(surface, point, views[v], sampler, rays) +
                       bakedLights(surface, point, views[v], sampler, rays);
            }
            result.radiance.push_back(sum / float(kPaths));
        }
        return result;
    }

private:
    static vec3 specular(const SurfaceReflectance& surface, const SurfacePoint& point, vec3 view, vec3 direction,
                         vec3 illuminance)
    {
        return shading::reflectSpecular(surface.f0(), surface.f90(), shading::ggxAlphaOf(surface.roughness),
                                        point.normal, view, direction, illuminance);
    }

    /// Light of surfaces and of the sky, by one path.
    vec3 reflected(const SurfaceReflectance& surface, const SurfacePoint& point, vec3 view, Sampler& sampler,
                   uint64_t& rays) const
    {
        const float alpha = shading::ggxAlphaOf(surface.roughness);
        const vec3 direction = shading::sampleBrdf(point.normal, view, alpha, 1.0f, 0.0f, sampler.next2());
        if (glm::dot(direction, point.geometricNormal) <= 0.0f) return vec3(0.0f);
        const float pdf = shading::brdfPdf(point.normal, view, direction, alpha, 1.0f);
        if (!(pdf > 0.0f)) return vec3(0.0f);
        const vec3 throughput = specular(surface, point, view, direction, vec3(1.0f / pdf));
        const Receiver from{paths_.surfaces().rayOrigin(point), point.normal};
        ++rays;
        const RayHit at = paths_.surfaces().nearest(from.position, direction, 0.0f, kInfinity);
        if (!at.found()) return throughput * paths_.light().sky().radiance(direction);
        return throughput * paths_.pathRadiance(at, direction, from, 0.0f, settings_.bounces, sampler, rays);
    }

    /// Highlights of the lights whose direct light is in the lightmap.
    vec3 bakedLights(const SurfaceReflectance& surface, const SurfacePoint& point, vec3 view, Sampler& sampler,
                     uint64_t& rays) const
    {
        vec3 sum(0.0f);
        paths_.light().forLightsNear(point.position, [&](const PunctualLight& light, uint32_t) {
            if (!light.directAtTexels && !light.maskOfLight) return;
            const vec2 disc = shading::sampleDisc(sampler.next2());
            vec3 highlight;
            if (light.isArea()) {
                const LightRay ray = sampleLightRay(light, point.position, disc);
                highlight =
                    specular(surface, point, view, ray.direction, light.radianceAt(point.position) * ray.solidAngle);
            } else {
                const shading::LightSample incoming = light.at(point.position);
                highlight = specular(surface, point, view, incoming.direction, incoming.illuminance);
            }
            if (highlight == vec3(0.0f)) return;
            sum += highlight *
                   glm::mix(1.0f, paths_.direct().lightVisibility(light, point, disc, rays), light.shadowStrength);
        });
        return sum;
    }

    const PathTracer& paths_;
    const IntegrationSettings& settings_;
};

} // namespace

Status traceSpecularLight(const PathTracer& paths, const IntegrationSettings& settings,
                          std::span<const SurfacePoint> points, std::span<const vec3> views,
                          std::span<SpecularEstimate> out, const Progress& progress, std::atomic<uint64_t>& rays)
{
    if (points.empty()) return {};
    const SpecularTracer tracer(paths, settings);
    const std::size_t viewsPerPoint = views.size() / points.size();
    const Progress quiet{{}, progress.cancel};
    const bool finished = parallelFor(points.size(), 8, quiet, "", [&](std::size_t begin, std::size_t end) {
        uint64_t traced = 0;
        for (std::size_t i = begin; i < end; ++i)
            out[i] = tracer.at(points[i], views.subspan(i * viewsPerPoint, viewsPerPoint), uint32_t(i), traced);
        rays += traced;
    });
    return paths.surfaces().outcome(finished);
}

} // namespace halflight
