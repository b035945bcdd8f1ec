#include "transport/reflections.h"

#include "halflight/base/image_filter.h"
#include "halflight/base/parallel.h"
#include "halflight/shading/brdf.h"
#include "halflight/shading/reflection.h"

#include <algorithm>

namespace halflight {
namespace {

constexpr uint32_t kReflectionSeed = 0x5eed0004u;
/// Perceptual roughness of surfaces that are seen in surfaces, at least: lamps in narrower lobes are bright dots.
constexpr float kLeastRoughnessOfSecond = 0.6f;

class RadianceTracer {
public:
    RadianceTracer(const RadianceSources& sources, vec3 position)
        : paths_(sources.paths), settings_(sources.settings), lightmap_(sources.lightmap),
          raysPerTexel_(sources.raysPerTexel), position_(position)
    {}

    vec3 texel(ivec2 at, int size, uint64_t& rays) const
    {
        vec3 sum(0.0f);
        for (int s = 0; s < raysPerTexel_; ++s) {
            Sampler sampler(settings_.seed ^ kReflectionSeed, uint32_t(at.y * size + at.x), uint32_t(s));
            const vec2 uv = (vec2(at) + sampler.next2()) / float(size);
            sum += radiance(shading::directionFromOctahedron(uv), sampler, rays);
        }
        return sum / float(raysPerTexel_);
    }

private:
    /// Diffuse light is that of the lightmap. Where surfaces have lobes, one path of mirrored rays goes on.
    vec3 radiance(vec3 direction, Sampler& sampler, uint64_t& rays) const
    {
        const RayTracer& surfaces = paths_.surfaces();
        const BakeGeometry& geometry = surfaces.geometry();
        ++rays;
        RayHit at = surfaces.nearest(position_, direction, 0.0f, kInfinity);
        if (!at.found()) return at.tint * paths_.light().sky().radiance(direction);
        vec3 sum(0.0f);
        vec3 throughput(1.0f);
        Receiver from{position_};
        float pdf = 0.0f;
        for (int depth = 0;; ++depth) {
            if (!at.found()) return sum + throughput * at.tint * paths_.light().sky().dimRadiance(direction);
            const SurfaceHit hit = surfaces.surfaceAt(at);
            if (geometry.partOf(hit.point.triangle).page < 0) {
                const int bounces = std::max(settings_.bounces - depth, 0);
                return sum + throughput * paths_.pathRadiance(at, direction, from, pdf, bounces, sampler, rays);
            }
            throughput *= at.tint;
            const vec3 irradiance = lightmapAt(hit.point, at.face.back != 0) + mixedLight(hit.point, sampler, rays);
            sum += throughput * (paths_.direct().weightedEmission(hit, direction, from, pdf) +
                                 shading::diffuseRadiance(paths_.albedoOf(hit.reflectance), irradiance));
            if (!paths_.glossy() || depth >= settings_.bounces) return sum;
            const SpecularLobe lobe(hit.reflectance, hit.point, direction,
                                    depth == 0 ? SpecularLobe::kLeastRoughness : kLeastRoughnessOfSecond);
            const PathTracer::Reflection next = paths_.reflect(hit, lobe, 1.0f, sampler, rays);
            sum += throughput * next.lights;
            throughput *= next.throughput;
            if (throughput == vec3(0.0f)) return sum;
            direction = next.direction;
            from = next.from;
            pdf = next.pdf;
            at = next.next;
        }
    }

    vec3 lightmapAt(const SurfacePoint& point, bool back) const
    {
        const BakeGeometry& geometry = paths_.surfaces().geometry();
        const BakeGeometry::Part& part = geometry.partOf(point.triangle);
        // The back half of a sheet follows its front half, with reversed winding.
        const bool ofBackHalf = back && part.side == SurfaceSide::Front;
        const std::array<vec2, 3> t = geometry.texelsOf(point.triangle + (ofBackHalf ? part.triangleCount : 0));
        const vec2 b = ofBackHalf ? vec2(point.barycentric.y, point.barycentric.x) : point.barycentric;
        const vec2 texel = (1.0f - b.x - b.y) * t[0] + b.x * t[1] + b.y * t[2];
        return bilinear(lightmap_[std::size_t(part.page)], texel);
    }

    /// Irradiance by one of the lights whose direct light the lightmap leaves to the renderer.
    vec3 mixedLight(const SurfacePoint& point, Sampler& sampler, uint64_t& rays) const
    {
        const auto contribution = [&](const PunctualLight& light, vec2 disc, float probability) {
            if (light.directAtTexels || light.maskOfLight) return vec3(0.0f);
            const LightRay ray = light.isArea() ? sampleLightRay(light, point.position, disc) : LightRay{};
            return light.irradianceBy(ray, point.position, point.normal) / probability;
        };
        const SceneLight::LightChoice choice = paths_.light().chooseLight(point, sampler, contribution);
        if (choice.light == nullptr) return vec3(0.0f);
        return choice.irradiance(paths_.direct().lightVisibility(*choice.light, point, choice.disc, rays));
    }

    const PathTracer& paths_;
    const IntegrationSettings& settings_;
    std::span<const ImageRgb32f> lightmap_;
    int raysPerTexel_;
    vec3 position_;
};

} // namespace

Status traceRadianceAround(const RadianceSources& sources, vec3 position, ImageRgb32f& map, const Progress& progress,
                           std::atomic<uint64_t>& rays)
{
    const RadianceTracer tracer(sources, position);
    const int size = map.width();
    const Progress quiet{{}, progress.cancel};
    const bool finished = parallelFor(std::size_t(map.height()), 1, quiet, "", [&](std::size_t begin, std::size_t end) {
        uint64_t traced = 0;
        for (auto y = int(begin); y < int(end); ++y)
            for (int x = 0; x < size; ++x) map(x, y) = tracer.texel({x, y}, size, traced);
        rays += traced;
    });
    return sources.paths.surfaces().outcome(finished);
}

} // namespace halflight
