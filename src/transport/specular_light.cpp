// What surfaces reflect by their specular lobes: the truth that reflection probes are judged by.

#include "transport/reflections.h"
#include "transport/sample/share_rays.h"

#include "halflight/base/parallel.h"
#include "halflight/shading/brdf_sampling.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace halflight {
namespace {

constexpr uint32_t kSpecularSeed = 0x5eed0009u;
constexpr uint32_t kLightSeed = 0x5eed000au;
/// Paths per point and view. Judgements are sums over many points, where their noise averages out.
constexpr int kPaths = 12;
/// Lights of which each gets a shadow ray per path. More lights share these rays.
constexpr std::size_t kSpecularLightsWithOwnRays = 4;

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
                sum += reflected(surface, point, views[v], sampler, rays);
            }
            const uint32_t id = hashCombine(index, uint32_t(v));
            result.radiance.push_back(sum / float(kPaths) + bakedLights(surface, point, views[v], id, rays));
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
        if (!at.found()) return throughput * at.tint * paths_.light().sky().radiance(direction);
        return throughput * paths_.pathRadiance(at, direction, from, 0.0f, settings_.bounces, sampler, rays);
    }

    /// Highlights of the lights whose direct light is in the lightmap.
    vec3 bakedLights(const SurfaceReflectance& surface, const SurfacePoint& point, vec3 view, uint32_t id,
                     uint64_t& rays) const
    {
        std::vector<const PunctualLight*> lights;
        std::vector<float> weights;
        paths_.light().forLightsNear(point.position, [&](const PunctualLight& light, uint32_t) {
            if (!light.directAtTexels && !light.maskOfLight) return;
            const float weight = highlightOf(surface, point, view, light);
            if (weight <= 0.0f) return;
            lights.push_back(&light);
            weights.push_back(weight);
        });
        const uint32_t seed = settings_.seed ^ kLightSeed;
        vec3 sum(0.0f);
        const float u = unitFloat(hashCombine(seed, id));
        shareRays(weights, kPaths, kSpecularLightsWithOwnRays, u, [&](std::size_t i, int count, float scale) {
            vec3 ofLight(0.0f);
            for (int s = 0; s < count; ++s) {
                Sampler sampler(seed, hashCombine(id, uint32_t(i)), uint32_t(s));
                ofLight += highlight(surface, point, view, *lights[i], shading::sampleDisc(sampler.next2()), rays);
            }
            sum += ofLight * (scale / float(count));
        });
        return sum;
    }

    /// Of the part of a light that a point of the unit disc stands for.
    vec3 highlight(const SurfaceReflectance& surface, const SurfacePoint& point, vec3 view, const PunctualLight& light,
                   vec2 disc, uint64_t& rays) const
    {
        vec3 unshadowed;
        if (light.isArea()) {
            const LightRay ray = sampleLightRay(light, point.position, disc);
            unshadowed =
                specular(surface, point, view, ray.direction, light.radianceAt(point.position) * ray.solidAngle);
        } else {
            const shading::LightSample incoming = light.at(point.position);
            unshadowed = specular(surface, point, view, incoming.direction, incoming.illuminance);
        }
        if (unshadowed == vec3(0.0f)) return unshadowed;
        return unshadowed * shadowOf(light, paths_.direct().lightVisibility(light, point, disc, rays));
    }

    /// About a light's highlight without shadows; more than 0 where it has one. An area light counts as a point in a
    /// lobe that is wider by its size (Karis 2013, "Real Shading in Unreal Engine 4", section on area lights).
    static float highlightOf(const SurfaceReflectance& surface, const SurfacePoint& point, vec3 view,
                             const PunctualLight& light)
    {
        if (!light.isArea()) {
            const shading::LightSample incoming = light.at(point.position);
            return luminance(specular(surface, point, view, incoming.direction, incoming.illuminance));
        }
        if (!light.reaches(point.position)) return 0.0f;
        constexpr float kLeastCosine = 0.01f; // part of a light may be above the horizon where its middle is not
        const float solidAngle = light.roughSolidAngle(point.position);
        const float alpha = std::min(shading::ggxAlphaOf(surface.roughness) + 0.5f * std::sqrt(solidAngle), 1.0f);
        vec3 direction = glm::normalize(light.position - point.position);
        direction += point.normal * std::max(kLeastCosine - glm::dot(point.normal, direction), 0.0f);
        const vec3 illuminance = light.radianceAt(point.position) * solidAngle;
        return luminance(shading::reflectSpecular(surface.f0(), surface.f90(), alpha, point.normal, view,
                                                  glm::normalize(direction), illuminance));
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
