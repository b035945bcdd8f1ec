#include "transport/sample/direct_light.h"

#include "halflight/shading/sampling.h"

#include <algorithm>
#include <cmath>

namespace halflight {

using shading::powerHeuristic;
using shading::rouletteSurvival;

/// Origin of shadow rays.
static vec3 smoothOrigin(const BakeGeometry& geometry, const SurfacePoint& point)
{
    const std::array<vec3, 3> normals = geometry.normalsOf(point.triangle);
    const std::array<vec3, 3> corners = geometry.cornersOf(point.triangle);
    const vec3 weights(1.0f - point.barycentric.x - point.barycentric.y, point.barycentric);
    const bool turned = glm::dot(geometry.geometricNormal(point.triangle), point.geometricNormal) < 0.0f;
    return shading::pointOnCurvedSurface(point.position, weights, corners[0], corners[1], corners[2], normals[0],
                                         normals[1], normals[2], point.geometricNormal, turned);
}

vec3 DirectLight::shadowOrigin(const SurfacePoint& point, uint64_t& rays) const
{
    const float epsilon = tracer_.epsilonAt(point.position);
    const vec3 flat = point.position + point.geometricNormal * epsilon;
    const vec3 origin = smoothOrigin(tracer_.geometry(), point) + point.geometricNormal * epsilon;
    // The raised origin must not be behind another surface.
    const float lift = glm::distance(flat, origin);
    if (lift <= shading::kLeastLift * epsilon) return origin;
    ++rays;
    return tracer_.occluded(flat, (origin - flat) / lift, 0.0f, lift) ? flat : origin;
}

Ray DirectLight::shadowRay(const PunctualLight& light, const SurfacePoint& point, vec2 disc, uint64_t& rays) const
{
    const vec3 origin = shadowOrigin(point, rays);
    const LightRay ray = sampleLightRay(light, origin, disc);
    ++rays;
    return {origin, 0.0f, ray.direction, ray.distance * kShortOfSurface};
}

vec3 DirectLight::lightVisibility(const PunctualLight& light, const SurfacePoint& point, vec2 disc,
                                  uint64_t& rays) const
{
    if (!shadowsFall(light, point)) return vec3(1.0f);
    const Ray ray = shadowRay(light, point, disc, rays);
    return tracer_.transmittance(ray.origin, ray.direction, ray.tMin, ray.tMax);
}

vec3 DirectLight::lightVisibilityInSpace(const PunctualLight& light, vec3 position, const LightRay& ray,
                                         uint64_t& rays) const
{
    if (light.castShadows == 0) return vec3(1.0f);
    ++rays;
    return tracer_.transmittance(position, ray.direction, 0.0f, ray.distance * kShortOfSurface);
}

DirectLight::OfLight DirectLight::punctualIrradiance(const SurfacePoint& point, bool direct, Sampler& sampler,
                                                     uint64_t& rays) const
{
    const SceneLight::LightChoice choice = light_.choosePunctual(point, direct, sampler);
    if (choice.light == nullptr) return {};
    return {choice.irradiance(lightVisibility(*choice.light, point, choice.disc, rays)), choice.light->component};
}

DirectLight::EmitterAtSurface DirectLight::emitterIrradiance(const SurfacePoint& point, float otherIlluminance,
                                                             Sampler& sampler, uint64_t& rays) const
{
    if (light_.emitters().empty()) return {};
    const Receiver receiver{tracer_.rayOrigin(point), point.normal};
    const float survival =
        otherIlluminance > 0.0f
            ? rouletteSurvival(light_.emitters().unshadowed(receiver.position, receiver.normal), otherIlluminance)
            : 1.0f;
    if (survival < 1.0f && sampler.next1() >= survival) return {};
    const EmitterSample s = light_.emitters().sample(receiver.position, receiver.normal, sampler.next2());
    const NextEventContribution next = s.from(receiver.position, receiver.normal, point.geometricNormal);
    if (next.distance <= 0.0f || s.radiance == vec3(0.0f)) return {};
    ++rays;
    const vec3 transmittance =
        tracer_.transmittance(receiver.position, next.direction, 0.0f, next.distance * kShortOfSurface);
    if (transmittance == vec3(0.0f)) return {};
    return {next.direction, s.radiance * (transmittance * next.factor / survival), s.component};
}

DirectLight::EmitterAtSurface DirectLight::skyIrradiance(const SurfacePoint& point, float otherIlluminance,
                                                         Sampler& sampler, uint64_t& rays) const
{
    if (!light_.sky().samples()) return {};
    const float survival = rouletteSurvival(light_.sky().brightIlluminance(), otherIlluminance);
    if (survival < 1.0f && sampler.next1() >= survival) return {};
    const SkyLight::Sample s = light_.sky().sample(sampler.next2());
    const float cosine = glm::dot(point.normal, s.direction);
    if (cosine <= 0.0f || glm::dot(point.geometricNormal, s.direction) <= 0.0f) return {};
    ++rays;
    const vec3 transmittance = tracer_.transmittance(tracer_.rayOrigin(point), s.direction, 0.0f, kInfinity);
    return {s.direction, s.radiance * (transmittance * cosine / (s.pdf * survival)), light_.skyComponent()};
}

DirectLight::EmitterInSpace DirectLight::skyInSpace(vec3 position, Sampler& sampler, uint64_t& rays) const
{
    if (!light_.sky().samples()) return {};
    const SkyLight::Sample s = light_.sky().sample(sampler.next2());
    ++rays;
    return {s.direction, s.radiance * (tracer_.transmittance(position, s.direction, 0.0f, kInfinity) / s.pdf),
            light_.skyComponent()};
}

DirectLight::EmitterInSpace DirectLight::emitterInSpace(vec3 position, float directionPdf, Sampler& sampler,
                                                        uint64_t& rays) const
{
    if (light_.emitters().empty()) return {};
    const EmitterSample s = light_.emitters().sample(position, vec3(0.0f), sampler.next2());
    const shading::SeenEmitter seen = s.seenFrom(position);
    if (seen.pdf <= 0.0f) return {};
    ++rays;
    const vec3 transmittance = tracer_.transmittance(position, seen.direction, 0.0f, seen.distance * kShortOfSurface);
    const float weight = s.rayVisible ? powerHeuristic(seen.pdf, directionPdf) : 1.0f;
    return {seen.direction, s.radiance * (transmittance * weight / seen.pdf), s.component};
}

vec3 DirectLight::weightedEmission(const SurfaceHit& hit, vec3 direction, const Receiver& from,
                                   float directionPdf) const
{
    if (hit.emission == vec3(0.0f) || directionPdf <= 0.0f) return hit.emission;
    const float cosine = std::abs(glm::dot(hit.point.geometricNormal, direction));
    if (cosine <= 0.0f) return hit.emission;
    const float pdfArea = light_.emitters().pdfArea(from, hit.point.triangle);
    return hit.emission * misWeightOfRay(directionPdf, pdfArea, hit.distance, cosine);
}

DirectLight::Reflected DirectLight::reflectedEmitters(const SurfaceHit& hit, const SpecularLobe& lobe, Sampler& sampler,
                                                      uint64_t& rays) const
{
    if (light_.emitters().empty()) return {};
    const vec3 origin = tracer_.rayOrigin(hit.point);
    const EmitterSample s = light_.emitters().sample(origin, hit.point.normal, sampler.next2());
    const shading::SeenEmitter seen = s.seenFrom(origin);
    if (seen.pdf <= 0.0f || glm::dot(seen.direction, hit.point.geometricNormal) <= 0.0f) return {};
    const float weight = s.rayVisible ? powerHeuristic(seen.pdf, lobe.pdf(seen.direction)) : 1.0f;
    const vec3 light = lobe.reflected(seen.direction, s.radiance * (weight / seen.pdf));
    if (light == vec3(0.0f)) return {};
    ++rays;
    const vec3 share = tracer_.transmittance(origin, seen.direction, 0.0f, seen.distance * kShortOfSurface);
    return {light * share, s.component};
}

vec3 DirectLight::reflectedSky(const SurfaceHit& hit, const SpecularLobe& lobe, Sampler& sampler, uint64_t& rays) const
{
    if (!light_.sky().samples()) return vec3(0.0f);
    const SkyLight::Sample s = light_.sky().sample(sampler.next2());
    if (glm::dot(hit.point.geometricNormal, s.direction) <= 0.0f) return vec3(0.0f);
    const vec3 light = lobe.reflected(s.direction, s.radiance / s.pdf);
    if (light == vec3(0.0f)) return light;
    ++rays;
    return light * tracer_.transmittance(tracer_.rayOrigin(hit.point), s.direction, 0.0f, kInfinity);
}

} // namespace halflight
