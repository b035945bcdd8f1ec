#include "bake_cpu/reflections.h"

#include "halflight/base/image_filter.h"
#include "halflight/base/parallel.h"
#include "halflight/shading/brdf.h"
#include "halflight/shading/reflection.h"

#include <algorithm>

namespace halflight {
namespace {

constexpr uint32_t kReflectionSeed = 0x5eed0004u;
/// Rays per texel of a map: its edges are antialiased, and soft shadows of mixed lights have 17 steps.
constexpr int kRaysPerTexel = 16;

class RadianceTracer {
public:
    RadianceTracer(const PathTracer& paths, const IntegrationSettings& settings, vec3 position,
                   std::span<const ImageRgb32f> lightmap)
        : paths_(paths), settings_(settings), position_(position), lightmap_(lightmap)
    {}

    vec3 texel(ivec2 at, int size, uint64_t& rays) const
    {
        vec3 sum(0.0f);
        for (int s = 0; s < kRaysPerTexel; ++s) {
            Sampler sampler(settings_.seed ^ kReflectionSeed, uint32_t(at.y * size + at.x), uint32_t(s));
            const vec2 uv = (vec2(at) + sampler.next2()) / float(size);
            sum += radiance(shading::directionFromOctahedron(uv), sampler, rays);
        }
        return sum / float(kRaysPerTexel);
    }

private:
    vec3 radiance(vec3 direction, Sampler& sampler, uint64_t& rays) const
    {
        ++rays;
        const RayTracer& surfaces = paths_.surfaces();
        const RayHit at = surfaces.nearest(position_, direction, 0.0f, kInfinity);
        if (!at.found) return paths_.sky().radiance(direction);
        const BakeGeometry& geometry = surfaces.geometry();
        const SurfaceHit hit = surfaces.surfaceAt(at);
        const BakeGeometry::Part& part = geometry.partOf(hit.point.triangle);
        if (part.page < 0)
            return paths_.pathRadiance(at, direction, {position_}, 0.0f, settings_.bounces, sampler, rays);
        // The back half of a sheet follows its front half, with reversed winding.
        const bool ofBackHalf = at.back && part.side == SurfaceSide::Front;
        const std::array<vec2, 3> t = geometry.texelsOf(hit.point.triangle + (ofBackHalf ? part.triangleCount : 0));
        const vec2 b = ofBackHalf ? vec2(hit.point.barycentric.y, hit.point.barycentric.x) : hit.point.barycentric;
        const vec2 texel = (1.0f - b.x - b.y) * t[0] + b.x * t[1] + b.y * t[2];
        const vec3 irradiance =
            bilinear(lightmap_[std::size_t(part.page)], texel) + mixedLight(hit.point, sampler, rays);
        return hit.emission + shading::diffuseRadiance(hit.reflectance.transportAlbedo(), irradiance);
    }

    /// Irradiance by one of the lights whose direct light the lightmap leaves to the renderer.
    vec3 mixedLight(const SurfacePoint& point, Sampler& sampler, uint64_t& rays) const
    {
        const auto contribution = [&](const PunctualLight& light, vec2 disc, float probability) {
            if (light.directAtTexels || light.maskOfLight) return vec3(0.0f);
            const LightRay ray = light.isArea() ? sampleLightRay(light, point.position, disc) : LightRay{};
            return light.irradianceBy(ray, point.position, point.normal) / probability;
        };
        const PathTracer::LightChoice choice = paths_.chooseLight(point, sampler, contribution);
        if (choice.light == nullptr) return vec3(0.0f);
        return choice.irradiance(paths_.lightVisibility(*choice.light, point, choice.disc, rays));
    }

    const PathTracer& paths_;
    const IntegrationSettings& settings_;
    vec3 position_;
    std::span<const ImageRgb32f> lightmap_;
};

} // namespace

bool traceRadianceAround(const PathTracer& paths, const IntegrationSettings& settings, vec3 position,
                         std::span<const ImageRgb32f> lightmap, ImageRgb32f& map, const Progress& progress,
                         std::atomic<uint64_t>& rays)
{
    const RadianceTracer tracer(paths, settings, position, lightmap);
    const int size = map.width();
    const Progress quiet{{}, progress.cancel};
    return parallelFor(std::size_t(map.height()), 1, quiet, "", [&](std::size_t begin, std::size_t end) {
        uint64_t traced = 0;
        for (auto y = int(begin); y < int(end); ++y)
            for (int x = 0; x < size; ++x) map(x, y) = tracer.texel({x, y}, size, traced);
        rays += traced;
    });
}

} // namespace halflight
