#include "bake_cpu/reference/reference_tracer.h"

#include <algorithm>
#include <cmath>

namespace halflight {

ReferenceTracer::ReferenceTracer(const Scene& scene, const PathTracer& paths, const Options& options)
    : paths_(paths), materials_(scene, paths.surfaces()), options_(options)
{}

ReferenceTracer::Hit ReferenceTracer::surfaceAt(const RayHit& at, vec3 view, bool first) const
{
    const RayTracer& surfaces = paths_.surfaces();
    const uint32_t triangle = surfaces.triangleAt(at.face.hitIndex);
    const bool back = at.face.back != 0;
    SurfacePoint point = surfacePoint(surfaces.geometry(), triangle, at.barycentric);
    if (back) {
        point.normal = -point.normal;
        point.geometricNormal = -point.geometricNormal;
    }
    point.normal = materials_.mappedNormal(point, back);
    SurfaceReflectance surface = materials_.reflectanceAt(triangle, at.barycentric);
    if (options_.surfaces == ReferenceSurfaces::Diffuse ||
        (first && options_.surfaces == ReferenceSurfaces::DiffuseView)) {
        surface.baseColor = surface.transportAlbedo();
        surface.metallic = surface.specular = 0.0f;
    }
    const vec3 emission = surfaces.hitHiddenBack(at) ? vec3(0.0f) : materials_.emissionAt(triangle, at.barycentric);
    return {point, emission, Scattering(surface, point.normal, point.geometricNormal, view)};
}

/// Direct light of one light, chosen by what it would contribute without shadows. Light comes from the sampled point of
/// a light with a size, so that its highlight has that size too. That of area lights has its MIS weight.
vec3 ReferenceTracer::punctualLight(const Hit& hit, Sampler& sampler, uint64_t& rays) const
{
    const auto choice =
        paths_.light().chooseLight(hit.point, sampler, [&](const PunctualLight& light, vec2 disc, float probability) {
            if (light.isArea()) return areaContribution(light, hit, disc) / probability;
            const vec3 illuminance = light.at(hit.point.position).illuminance;
            if (illuminance == vec3(0.0f)) return vec3(0.0f);
            const vec3 direction = sampleLightRay(light, hit.point.position, disc).direction;
            return hit.scattering.reflected(direction, illuminance / probability);
        });
    if (choice.light == nullptr) return vec3(0.0f);
    return choice.irradiance(paths_.direct().lightVisibility(*choice.light, hit.point, choice.disc, rays));
}

vec3 ReferenceTracer::areaContribution(const PunctualLight& light, const Hit& hit, vec2 disc) const
{
    if (options_.emitters == EmitterSampling::Directions) return vec3(0.0f);
    const LightRay ray = sampleLightRay(light, hit.point.position, disc);
    if (ray.solidAngle <= 0.0f) return vec3(0.0f);
    // As of other lights, light from below the triangle is not excluded; the lobe has no samples there.
    const bool alone = options_.emitters == EmitterSampling::Surfaces || !hit.scattering.above(ray.direction);
    const float weight =
        alone ? 1.0f : shading::powerHeuristic(1.0f / ray.solidAngle, hit.scattering.pdf(ray.direction));
    return hit.scattering.reflected(ray.direction, light.radianceAt(hit.point.position) * (ray.solidAngle * weight));
}

/// Radiance of the area lights that a sampled direction of the hit meets, with its MIS weight. `next` is what the ray
/// meets of the scene.
vec3 ReferenceTracer::areaLightsAlong(const Hit& hit, vec3 direction, float directionPdf, const RayHit& next,
                                      uint64_t& rays) const
{
    vec3 radiance(0.0f);
    if (options_.emitters == EmitterSampling::Surfaces) return radiance;
    const bool alone = options_.emitters == EmitterSampling::Directions;
    const vec3 origin = hit.point.position;
    paths_.light().forLightsNear(origin, [&](const PunctualLight& light, uint32_t) {
        if (!light.isArea() || !light.bounces) return;
        const vec3 toCenter = light.position - origin;
        const float distance =
            shading::meetAreaLight(light.type, toCenter, light.halfWidth, light.halfHeight, direction);
        if (distance <= 0.0f) return;
        const vec3 visible = paths_.direct().shadowsFall(light, hit.point)
                                 ? shadowOf(light, visibleUpTo(hit, direction, distance * kShortOfSurface, next, rays))
                                 : vec3(1.0f);
        const float pdf =
            shading::areaSamplePdf(light.type, toCenter, light.halfWidth, light.halfHeight, distance * direction);
        const float weight = alone ? 1.0f : shading::powerHeuristic(directionPdf, pdf);
        radiance += light.radianceAt(origin) * (visible * weight);
    });
    return radiance;
}

/// Share of light that comes from a distance along a ray from a hit. `next`: what the ray meets, by chance where that
/// is glass; its tint is that of all glass before it, also beyond the distance.
vec3 ReferenceTracer::visibleUpTo(const Hit& hit, vec3 direction, float distance, const RayHit& next,
                                  uint64_t& rays) const
{
    const RayTracer& surfaces = paths_.surfaces();
    if (!surfaces.anyTinted()) return vec3(next.found() && next.distance < distance ? 0.0f : 1.0f);
    ++rays;
    return surfaces.transmittance(surfaces.rayOrigin(hit.point), direction, 0.0f, distance);
}

vec3 ReferenceTracer::emitterLight(const Hit& hit, Sampler& sampler, uint64_t& rays) const
{
    if (paths_.light().emitters().empty() || options_.emitters == EmitterSampling::Directions) return vec3(0.0f);
    const RayTracer& surfaces = paths_.surfaces();
    const vec3 origin = paths_.surfaces().rayOrigin(hit.point);
    const EmitterSample s = paths_.light().emitters().sample(origin, hit.point.normal, sampler.next2());
    const shading::SeenEmitter seen = s.seenFrom(origin);
    if (seen.pdf <= 0.0f || !hit.scattering.above(seen.direction)) return vec3(0.0f);
    const vec3 emission =
        materials_.emissionAt(s.triangle, s.barycentric) * surfaces.materials().coverageAt(s.triangle, s.barycentric);
    const bool alone = !s.rayVisible || options_.emitters == EmitterSampling::Surfaces;
    const float weight = alone ? 1.0f : shading::powerHeuristic(seen.pdf, hit.scattering.pdf(seen.direction));
    const vec3 light = hit.scattering.reflected(seen.direction, emission) * (weight / seen.pdf);
    if (light == vec3(0.0f)) return light;
    ++rays;
    return light * surfaces.transmittance(origin, seen.direction, 0.0f, seen.distance * kShortOfSurface);
}

vec3 ReferenceTracer::skyLight(const Hit& hit, Sampler& sampler, uint64_t& rays) const
{
    if (!paths_.light().sky().samples() || options_.emitters == EmitterSampling::Directions) return vec3(0.0f);
    const SkyLight::Sample s = paths_.light().sky().sample(sampler.next2());
    if (!hit.scattering.above(s.direction)) return vec3(0.0f);
    const bool alone = options_.emitters == EmitterSampling::Surfaces;
    const float weight = alone ? 1.0f : shading::powerHeuristic(s.pdf, hit.scattering.pdf(s.direction));
    const vec3 light = hit.scattering.reflected(s.direction, s.radiance) * (weight / s.pdf);
    if (light == vec3(0.0f)) return light;
    ++rays;
    return light *
           paths_.surfaces().transmittance(paths_.surfaces().rayOrigin(hit.point), s.direction, 0.0f, kInfinity);
}

/// The sky as a ray meets it, its bright part with its MIS weight.
vec3 ReferenceTracer::skyAlong(vec3 direction, float directionPdf) const
{
    const SkyLight& sky = paths_.light().sky();
    if (directionPdf <= 0.0f || !sky.samples() || options_.emitters == EmitterSampling::Directions)
        return sky.radiance(direction);
    if (options_.emitters == EmitterSampling::Surfaces) return sky.dimRadiance(direction);
    const float weight = shading::powerHeuristic(directionPdf, sky.pdf(direction));
    return sky.dimRadiance(direction) + sky.brightRadiance(direction) * weight;
}

/// MIS weight of emission that a sampled direction has met.
float ReferenceTracer::emissionWeight(const Hit& hit, vec3 direction, float distance, const Receiver& from,
                                      float directionPdf) const
{
    if (directionPdf <= 0.0f || options_.emitters == EmitterSampling::Directions) return 1.0f;
    const float cosine = std::abs(glm::dot(hit.point.geometricNormal, direction));
    const float pdfArea = paths_.light().emitters().pdfArea(from, hit.point.triangle);
    if (pdfArea <= 0.0f || cosine <= 0.0f) return 1.0f;
    if (options_.emitters == EmitterSampling::Surfaces) return 0.0f;
    return misWeightOfRay(directionPdf, pdfArea, distance, cosine);
}

vec3 ReferenceTracer::limited(vec3 light) const
{
    const float bright = luminance(light);
    return options_.clampNits > 0.0f && bright > options_.clampNits ? light * (options_.clampNits / bright) : light;
}

vec3 ReferenceTracer::radiance(vec3 origin, vec3 direction, RayUse use, int bounces, Sampler& sampler,
                               uint64_t& rays) const
{
    const RayTracer& surfaces = paths_.surfaces();
    vec3 radiance(0.0f);
    vec3 throughput(1.0f);
    Receiver from;
    float pdf = 0.0f;
    ++rays;
    RayHit at = surfaces.nearest(origin, direction, 0.0f, kInfinity, use);
    for (int depth = 0;; ++depth) {
        const auto add = [&](vec3 light) { radiance += depth > 0 ? limited(throughput * light) : throughput * light; };
        throughput *= at.tint;
        if (!at.found()) {
            add(skyAlong(direction, pdf));
            break;
        }
        if (depth == 0 && surfaces.materials().of(surfaces.triangleAt(at.face.hitIndex)).unlit) {
            return throughput *
                   materials_.reflectanceAt(surfaces.triangleAt(at.face.hitIndex), at.barycentric).baseColor;
        }
        const Hit hit = surfaceAt(at, -direction, depth == 0);
        if (hit.emission != vec3(0.0f)) add(hit.emission * emissionWeight(hit, direction, at.distance, from, pdf));
        if (depth > bounces || hit.scattering.black()) break;
        add(punctualLight(hit, sampler, rays) + emitterLight(hit, sampler, rays) + skyLight(hit, sampler, rays));

        const float uLobe = sampler.next1();
        direction = hit.scattering.sample(uLobe, sampler.next2());
        if (direction == vec3(0.0f)) break;
        pdf = hit.scattering.pdf(direction);
        throughput *= hit.scattering.reflected(direction, vec3(1.0f)) / pdf;
        const float survival = std::max({throughput.x, throughput.y, throughput.z});
        if (!(survival > 0.0f)) break;
        if (depth > 0 && !survivesRoulette(survival, sampler, throughput)) break;
        from = {paths_.surfaces().rayOrigin(hit.point), hit.point.normal};
        ++rays;
        at = surfaces.nearest(from.position, direction, 0.0f, kInfinity);
        const vec3 ofAreaLights = throughput * areaLightsAlong(hit, direction, pdf, at, rays);
        radiance += depth > 0 ? limited(ofAreaLights) : ofAreaLights;
        if (depth == 0 && at.found() && options_.surfaces == ReferenceSurfaces::DiffuseBounces) {
            radiance += limited(throughput * paths_.pathRadiance(at, direction, from, pdf, bounces, sampler, rays));
            break;
        }
    }
    return radiance;
}

} // namespace halflight
