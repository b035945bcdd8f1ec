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

/// With several lightmaps, light is noted by component.
class RadianceTracer {
public:
    RadianceTracer(const RadianceSources& sources, vec3 position)
        : paths_(sources.paths), settings_(sources.settings), lightmaps_(sources.lightmaps),
          raysPerTexel_(sources.raysPerTexel), position_(position)
    {}

    /// Writes the texel of each map.
    void texel(ivec2 at, std::span<ImageRgb32f> maps, PathLights& lights, uint64_t& rays) const
    {
        const int size = maps[0].width();
        vec3 sum(0.0f);
        lights.clear();
        for (int s = 0; s < raysPerTexel_; ++s) {
            Sampler sampler(settings_.seed ^ kReflectionSeed, uint32_t(at.y * size + at.x), uint32_t(s));
            const vec2 uv = (vec2(at) + sampler.next2()) / float(size);
            sum += radiance(shading::directionFromOctahedron(uv), sampler, rays, byComponent() ? &lights : nullptr);
        }
        if (!byComponent()) {
            maps[0](at.x, at.y) = sum / float(raysPerTexel_);
            return;
        }
        for (ImageRgb32f& map : maps) map(at.x, at.y) = vec3(0.0f);
        for (const PathLight& light : lights)
            maps[std::size_t(light.component)](at.x, at.y) += light.radiance / float(raysPerTexel_);
    }

private:
    [[nodiscard]] bool byComponent() const { return lightmaps_.size() > 1; }
    static void note(PathLights* lights, int component, vec3 radiance)
    {
        if (lights != nullptr && radiance != vec3(0.0f)) lights->push_back({component, 0, radiance});
    }
    /// `radiance` of the sky.
    vec3 sky(vec3 direction, vec3 radiance, vec3 throughput, PathLights* lights) const
    {
        if (lights != nullptr)
            paths_.light().splitSky(direction, radiance,
                                    [&](int component, vec3 part) { note(lights, component, throughput * part); });
        return throughput * radiance;
    }

    /// Diffuse light is that of the lightmap. Where surfaces have lobes, one path of mirrored rays goes on. `lights`:
    /// null, or receives the parts of components.
    vec3 radiance(vec3 direction, Sampler& sampler, uint64_t& rays, PathLights* lights) const
    {
        const RayTracer& surfaces = paths_.surfaces();
        const BakeGeometry& geometry = surfaces.geometry();
        ++rays;
        RayHit at = surfaces.nearest(position_, direction, 0.0f, kInfinity);
        if (!at.found()) return sky(direction, paths_.light().sky().radiance(direction), at.tint, lights);
        vec3 sum(0.0f);
        vec3 throughput(1.0f);
        Receiver from{position_};
        float pdf = 0.0f;
        PathTracer::SampledLights sampled;
        for (int depth = 0;; ++depth) {
            if (!at.found())
                return sum + sky(direction, paths_.light().sky().dimRadiance(direction), throughput * at.tint, lights);
            const SurfaceHit hit = surfaces.surfaceAt(at);
            if (geometry.partOf(hit.point.triangle).page < 0) {
                const int bounces = std::max(settings_.bounces - depth, 0);
                const std::size_t before = lights != nullptr ? lights->size() : 0;
                const vec3 rest =
                    paths_.pathRadiance(at, direction, from, pdf, bounces, sampler, rays, {}, nullptr, lights);
                for (std::size_t i = before; lights != nullptr && i < lights->size(); ++i)
                    (*lights)[i].radiance *= throughput;
                return sum + throughput * rest;
            }
            throughput *= at.tint;
            sum += throughput *
                   diffuseLight(hit, at.face.back != 0, direction, from, pdf, throughput, sampler, rays, lights);
            if (!paths_.glossy() || depth >= settings_.bounces) return sum;
            const SpecularLobe lobe(hit.reflectance, hit.point, direction,
                                    depth == 0 ? SpecularLobe::kLeastRoughness : kLeastRoughnessOfSecond);
            const PathTracer::Reflection next =
                paths_.reflect(hit, lobe, 1.0f, sampler, rays, lights != nullptr ? &sampled : nullptr);
            sum += throughput * next.lights;
            if (lights != nullptr)
                for (const auto& light : sampled) note(lights, light.component, throughput * light.radiance);
            throughput *= next.throughput;
            if (throughput == vec3(0.0f)) return sum;
            direction = next.direction;
            from = next.from;
            pdf = next.pdf;
            at = next.next;
        }
    }

    /// Irradiance at a point, over a probability, by lights whose direct light the lightmap leaves to the renderer.
    static auto mixedAt(const SurfacePoint& point)
    {
        return [&point](const PunctualLight& light, vec2 disc, float probability) {
            if (light.directAtTexels || light.maskOfLight) return vec3(0.0f);
            const LightRay ray = light.isArea() ? sampleLightRay(light, point.position, disc) : LightRay{};
            return light.irradianceBy(ray, point.position, point.normal) / probability;
        };
    }

    /// Emission, and what the diffuse part of a surface reflects. `lights` receive it times `throughput`.
    vec3 diffuseLight(const SurfaceHit& hit, bool back, vec3 direction, const Receiver& from, float pdf,
                      vec3 throughput, Sampler& sampler, uint64_t& rays, PathLights* lights) const
    {
        const vec3 emission = paths_.direct().weightedEmission(hit, direction, from, pdf);
        const vec3 albedo = paths_.albedoOf(hit.reflectance);
        if (lights == nullptr) {
            const vec3 irradiance = lightmapAt(lightmaps_[0], hit.point, back) + mixedLight(hit.point, sampler, rays);
            return emission + shading::diffuseRadiance(albedo, irradiance);
        }
        const auto noteReflected = [&](int component, vec3 irradiance) {
            note(lights, component, throughput * shading::diffuseRadiance(albedo, irradiance));
        };
        note(lights, paths_.light().emissionComponent(hit.point.triangle), throughput * emission);
        for (std::size_t c = 0; c < lightmaps_.size(); ++c)
            noteReflected(int(c), lightmapAt(lightmaps_[c], hit.point, back));
        for (std::size_t chooser = 0; chooser < paths_.light().choosers(); ++chooser) {
            const auto choice = paths_.light().chooseLightFrom(chooser, hit.point, sampler, mixedAt(hit.point));
            if (choice.light != nullptr) noteReflected(choice.light->component, arriving(choice, hit.point, rays));
        }
        return vec3(0.0f); // what counts is noted
    }

    vec3 lightmapAt(std::span<const ImageRgb32f> lightmap, const SurfacePoint& point, bool back) const
    {
        const BakeGeometry& geometry = paths_.surfaces().geometry();
        const BakeGeometry::Part& part = geometry.partOf(point.triangle);
        // The back half of a sheet follows its front half, with reversed winding.
        const bool ofBackHalf = back && part.side == SurfaceSide::Front;
        const std::array<vec2, 3> t = geometry.texelsOf(point.triangle + (ofBackHalf ? part.triangleCount : 0));
        const vec2 b = ofBackHalf ? vec2(point.barycentric.y, point.barycentric.x) : point.barycentric;
        const vec2 texel = (1.0f - b.x - b.y) * t[0] + b.x * t[1] + b.y * t[2];
        return bilinear(lightmap[std::size_t(part.page)], texel);
    }

    vec3 arriving(const SceneLight::LightChoice& choice, const SurfacePoint& point, uint64_t& rays) const
    {
        return choice.irradiance(paths_.direct().lightVisibility(*choice.light, point, choice.disc, rays));
    }
    /// Of one of these lights.
    vec3 mixedLight(const SurfacePoint& point, Sampler& sampler, uint64_t& rays) const
    {
        const SceneLight::LightChoice choice = paths_.light().chooseLight(point, sampler, mixedAt(point));
        return choice.light == nullptr ? vec3(0.0f) : arriving(choice, point, rays);
    }

    const PathTracer& paths_;
    const IntegrationSettings& settings_;
    std::span<const std::span<const ImageRgb32f>> lightmaps_;
    int raysPerTexel_;
    vec3 position_;
};

} // namespace

Status traceRadianceAround(const RadianceSources& sources, vec3 position, std::span<ImageRgb32f> maps,
                           const Progress& progress, std::atomic<uint64_t>& rays)
{
    const RadianceTracer tracer(sources, position);
    const ivec2 size = maps[0].size();
    const Progress quiet{{}, progress.cancel};
    const bool finished = parallelFor(std::size_t(size.y), 1, quiet, "", [&](std::size_t begin, std::size_t end) {
        uint64_t traced = 0;
        PathLights lights;
        for (auto y = int(begin); y < int(end); ++y)
            for (int x = 0; x < size.x; ++x) tracer.texel({x, y}, maps, lights, traced);
        rays += traced;
    });
    return sources.paths.surfaces().outcome(finished);
}

} // namespace halflight
