#include "transport/sample/path_tracer.h"

#include "halflight/shading/brdf.h"
#include "halflight/shading/sampling.h"

#include <algorithm>
#include <cmath>

namespace halflight {

using shading::powerHeuristic;

PathTracer::PathTracer(const Scene& scene, const BakeGeometry& geometry, LightUse use, Bounces bounces,
                       const MakeKernels& makeKernels)
    : tracer_(scene, geometry, makeKernels), lights_(punctualLights(scene, use)), emitters_(tracer_), sky_(scene.sky),
      bounces_(bounces)
{
    // Up to 8 lights are chosen by their exact unshadowed contributions.
    constexpr std::ptrdiff_t kFewLights = 8;
    if (std::count_if(lights_.begin(), lights_.end(), [](const PunctualLight& l) { return l.bounces; }) > kFewLights) {
        punctualTree_ = punctualTree(lights_, lightOfItem_);
    }
    std::vector<const PunctualLight*> all;
    for (uint32_t i = 0; i < lights_.size(); ++i) {
        all.push_back(&lights_[i]);
        const bool inTree = !punctualTree_.empty() && lights_[i].type != shading::kLightDirectional;
        if (lights_[i].bounces && !inTree) alwaysChosenFrom_.push_back(i);
    }
    reach_ = LightReach(std::move(all));
}

vec3 PathTracer::rayOrigin(const SurfacePoint& point) const
{
    return point.position + point.geometricNormal * tracer_.epsilonAt(point.position);
}

vec3 PathTracer::gatherDirection(const SurfacePoint& point, vec2 u)
{
    vec3 tangent;
    vec3 bitangent;
    shading::orthonormalBasis(point.normal, tangent, bitangent);
    const vec3 local = shading::sampleCosineHemisphere(u);
    vec3 direction = local.x * tangent + local.y * bitangent + local.z * point.normal;
    // Hemispheres about interpolated normals reach below the triangle; such directions are reflected out of it.
    const float side = glm::dot(direction, point.geometricNormal);
    if (side < 0.0f) direction -= 2.0f * side * point.geometricNormal;
    return direction;
}

/// Origin of shadow rays on the curved surface that the vertex normals describe, so that the terminator does not show
/// the triangles (Hanika 2021, "Hacking the Shadow Terminator", Ray Tracing Gems II, chapter 4).
static vec3 smoothOrigin(const BakeGeometry& geometry, const SurfacePoint& point)
{
    const std::array<vec3, 3> normals = geometry.normalsOf(point.triangle);
    const std::array<vec3, 3> corners = geometry.cornersOf(point.triangle);
    const float weights[3] = {1.0f - point.barycentric.x - point.barycentric.y, point.barycentric.x,
                              point.barycentric.y};
    if (normals[0] == normals[1] && normals[0] == normals[2]) {
        return point.position;
    }
    const bool flipped = glm::dot(geometry.geometricNormal(point.triangle), point.geometricNormal) < 0.0f;
    vec3 position = point.position;
    for (std::size_t i = 0; i < 3; ++i) {
        const vec3 n = flipped ? -normals[i] : normals[i];
        if (glm::dot(n, point.geometricNormal) <= 0.0f) return point.position;
        const float below = std::min(0.0f, glm::dot(point.position - corners[i], n));
        position -= weights[i] * below * n;
    }
    return position;
}

vec3 PathTracer::shadowOrigin(const SurfacePoint& point, uint64_t& rays) const
{
    const float epsilon = tracer_.epsilonAt(point.position);
    const vec3 flat = point.position + point.geometricNormal * epsilon;
    const vec3 origin = smoothOrigin(tracer_.geometry(), point) + point.geometricNormal * epsilon;
    // The raised origin must not be behind another surface.
    const float lift = glm::distance(flat, origin);
    if (lift <= 4.0f * epsilon) return origin;
    ++rays;
    return tracer_.occluded(flat, (origin - flat) / lift, 0.0f, lift) ? flat : origin;
}

Ray PathTracer::shadowRay(const PunctualLight& light, const SurfacePoint& point, vec2 disc, uint64_t& rays) const
{
    const vec3 origin = shadowOrigin(point, rays);
    const LightRay ray = sampleLightRay(light, origin, disc);
    ++rays;
    return {origin, tracer_.epsilonAt(point.position), ray.direction, ray.distance * (1.0f - 1.0e-4f)};
}

float PathTracer::lightVisibility(const PunctualLight& light, const SurfacePoint& point, vec2 disc,
                                  uint64_t& rays) const
{
    if (!shadowsFall(light, point)) return 1.0f;
    const Ray ray = shadowRay(light, point, disc, rays);
    return tracer_.transmittance(ray.origin, ray.direction, ray.tMin, ray.tMax);
}

float PathTracer::lightVisibilityInSpace(const PunctualLight& light, vec3 position, const LightRay& ray,
                                         uint64_t& rays) const
{
    if (!light.castShadows) return 1.0f;
    ++rays;
    return tracer_.transmittance(position, ray.direction, 0.0f, ray.distance * (1.0f - 1.0e-4f));
}

PathTracer::LightChoice PathTracer::choosePunctual(const SurfacePoint& point, bool direct, Sampler& sampler) const
{
    return chooseLight(point, sampler, [&](const PunctualLight& light, vec2 disc, float probability) {
        if (light.isArea()) {
            const LightRay ray = sampleLightRay(light, point.position, disc);
            return light.irradianceBy(ray, point.position, point.normal) *
                   ((direct ? 1.0f : light.indirectMultiplier) / probability);
        }
        const shading::LightSample s = light.at(point.position);
        const float cosine = glm::dot(point.normal, s.direction);
        if (cosine <= 0.0f) return vec3(0.0f);
        return s.illuminance * (cosine * (direct ? 1.0f : light.indirectMultiplier) / probability);
    });
}

vec3 PathTracer::punctualIrradiance(const SurfacePoint& point, bool direct, Sampler& sampler, uint64_t& rays) const
{
    const LightChoice choice = choosePunctual(point, direct, sampler);
    if (choice.light == nullptr) return vec3(0.0f);
    return choice.irradiance(lightVisibility(*choice.light, point, choice.disc, rays));
}

PathTracer::EmitterAtSurface PathTracer::emitterIrradiance(const SurfacePoint& point, float otherIlluminance,
                                                           Sampler& sampler, uint64_t& rays) const
{
    if (emitters_.empty()) return {};
    const Receiver receiver{rayOrigin(point), point.normal};
    const float survival =
        otherIlluminance > 0.0f
            ? rouletteSurvival(emitters_.unshadowed(receiver.position, receiver.normal), otherIlluminance)
            : 1.0f;
    if (survival < 1.0f && sampler.next1() >= survival) return {};
    const EmitterSample s = emitters_.sample(receiver.position, receiver.normal, sampler.next2());
    const NextEventContribution next = s.from(receiver.position, receiver.normal, point.geometricNormal);
    if (next.distance <= 0.0f || s.radiance == vec3(0.0f)) return {};
    ++rays;
    const float transmittance =
        tracer_.transmittance(receiver.position, next.direction, 0.0f, next.distance * (1.0f - 1.0e-4f));
    if (transmittance <= 0.0f) return {};
    return {next.direction, s.radiance * (transmittance * next.factor / survival)};
}

PathTracer::EmitterAtSurface PathTracer::skyIrradiance(const SurfacePoint& point, float otherIlluminance,
                                                       Sampler& sampler, uint64_t& rays) const
{
    if (!sky_.samples()) return {};
    const float survival = rouletteSurvival(sky_.brightIlluminance(), otherIlluminance);
    if (survival < 1.0f && sampler.next1() >= survival) return {};
    const SkyLight::Sample s = sky_.sample(sampler.next2());
    const float cosine = glm::dot(point.normal, s.direction);
    if (cosine <= 0.0f || glm::dot(point.geometricNormal, s.direction) <= 0.0f) return {};
    ++rays;
    const float transmittance = tracer_.transmittance(rayOrigin(point), s.direction, 0.0f, kInfinity);
    return {s.direction, s.radiance * (transmittance * cosine / (s.pdf * survival))};
}

PathTracer::EmitterInSpace PathTracer::skyInSpace(vec3 position, Sampler& sampler, uint64_t& rays) const
{
    if (!sky_.samples()) return {};
    const SkyLight::Sample s = sky_.sample(sampler.next2());
    ++rays;
    return {s.direction, s.radiance * (tracer_.transmittance(position, s.direction, 0.0f, kInfinity) / s.pdf)};
}

PathTracer::EmitterInSpace PathTracer::emitterInSpace(vec3 position, float directionPdf, Sampler& sampler,
                                                      uint64_t& rays) const
{
    if (emitters_.empty()) return {};
    const EmitterSample s = emitters_.sample(position, vec3(0.0f), sampler.next2());
    if (s.pdfArea <= 0.0f) return {};
    const vec3 toEmitter = s.position - position;
    const float distance2 = glm::dot(toEmitter, toEmitter);
    if (distance2 <= 0.0f) return {};
    const float distance = std::sqrt(distance2);
    const vec3 direction = toEmitter / distance;
    float emitterCosine = -glm::dot(s.normal, direction);
    if (s.doubleSided) emitterCosine = std::abs(emitterCosine);
    if (emitterCosine <= 0.0f) return {};
    const float pdf = s.pdfArea * distance2 / emitterCosine;
    ++rays;
    const float transmittance = tracer_.transmittance(position, direction, 0.0f, distance * (1.0f - 1.0e-4f));
    if (transmittance <= 0.0f) return {};
    return {direction, s.radiance * (transmittance * (s.rayVisible ? powerHeuristic(pdf, directionPdf) : 1.0f) / pdf)};
}

vec3 PathTracer::weightedEmission(const SurfaceHit& hit, vec3 direction, const Receiver& from, float directionPdf) const
{
    if (hit.emission == vec3(0.0f) || directionPdf <= 0.0f) return hit.emission;
    const float cosine = std::abs(glm::dot(hit.point.geometricNormal, direction));
    if (cosine <= 0.0f) return hit.emission;
    const float pdfArea = emitters_.pdfArea(from, hit.point.triangle);
    return hit.emission * misWeightOfRay(directionPdf, pdfArea, hit.distance, cosine);
}

PathTracer::Incoming PathTracer::incoming(const Receiver& receiver, vec3 direction, float directionPdf, int bounces,
                                          Sampler& sampler, uint64_t& rays) const
{
    ++rays;
    const RayHit at = tracer_.nearest(receiver.position, direction, 0.0f, kInfinity);
    Incoming result;
    result.firstHitBackFace = tracer_.hitHiddenBack(at);
    result.radiance = pathRadiance(at, direction, receiver, directionPdf, bounces, sampler, rays);
    return result;
}

vec3 PathTracer::reflectedEmitters(const SurfaceHit& hit, const SpecularLobe& lobe, Sampler& sampler,
                                   uint64_t& rays) const
{
    if (emitters_.empty()) return vec3(0.0f);
    const vec3 origin = rayOrigin(hit.point);
    const EmitterSample s = emitters_.sample(origin, hit.point.normal, sampler.next2());
    const vec3 way = s.position - origin;
    const float distance = glm::length(way);
    if (s.pdfArea <= 0.0f || distance <= 0.0f) return vec3(0.0f);
    const vec3 direction = way / distance;
    const float front = -glm::dot(s.normal, direction);
    const float cosine = s.doubleSided ? std::abs(front) : front;
    if (cosine <= 0.0f || glm::dot(direction, hit.point.geometricNormal) <= 0.0f) return vec3(0.0f);
    const float pdf = s.pdfArea * distance * distance / cosine;
    const float weight = s.rayVisible ? powerHeuristic(pdf, lobe.pdf(direction)) : 1.0f;
    const vec3 light = lobe.reflected(direction, s.radiance * (weight / pdf));
    if (light == vec3(0.0f)) return light;
    ++rays;
    return light * tracer_.transmittance(origin, direction, 0.0f, distance * (1.0f - 1.0e-4f));
}

vec3 PathTracer::reflectedSky(const SurfaceHit& hit, const SpecularLobe& lobe, Sampler& sampler, uint64_t& rays) const
{
    if (!sky_.samples()) return vec3(0.0f);
    const SkyLight::Sample s = sky_.sample(sampler.next2());
    if (glm::dot(hit.point.geometricNormal, s.direction) <= 0.0f) return vec3(0.0f);
    const vec3 light = lobe.reflected(s.direction, s.radiance / s.pdf);
    if (light == vec3(0.0f)) return light;
    ++rays;
    return light * tracer_.transmittance(rayOrigin(hit.point), s.direction, 0.0f, kInfinity);
}

PathTracer::Reflection PathTracer::reflect(const SurfaceHit& hit, const SpecularLobe& lobe, float probability,
                                           Sampler& sampler, uint64_t& rays) const
{
    Reflection result;
    const LightChoice choice =
        chooseLight(hit.point, sampler, [&](const PunctualLight& light, vec2 disc, float probability) {
            const float scale = light.indirectMultiplier / probability;
            const LightRay ray = sampleLightRay(light, hit.point.position, disc);
            if (light.isArea())
                return lobe.reflected(ray.direction, light.radianceAt(hit.point.position) * (ray.solidAngle * scale));
            return lobe.reflected(ray.direction, light.at(hit.point.position).illuminance * scale);
        });
    if (choice.light != nullptr)
        result.lights = choice.irradiance(lightVisibility(*choice.light, hit.point, choice.disc, rays));
    result.lights += reflectedEmitters(hit, lobe, sampler, rays) + reflectedSky(hit, lobe, sampler, rays);
    result.lights /= probability;
    result.direction = lobe.sample(sampler.next2());
    if (result.direction == vec3(0.0f)) return result;
    result.pdf = lobe.pdf(result.direction);
    const vec3 throughput = lobe.reflected(result.direction, vec3(1.0f / (result.pdf * probability)));
    const float survival = std::min(brightest(throughput), 1.0f);
    if (!(survival > 0.0f) || !(sampler.next1() < survival)) return result;
    result.throughput = throughput / survival;
    result.from = {rayOrigin(hit.point), hit.point.normal};
    ++rays;
    result.next = tracer_.nearest(result.from.position, result.direction, 0.0f, kInfinity);
    return result;
}

// Path tracing (Kajiya 1986, "The Rendering Equation"). At each surface the path goes on by the diffuse part, whose
// throughput is the albedo because directions are cosine-distributed, or by the specular lobe.
vec3 PathTracer::pathRadiance(RayHit at, vec3 direction, Receiver from, float directionPdf, int bounces,
                              Sampler& sampler, uint64_t& rays, const RadianceLookup& lookup,
                              std::vector<vec3>* byBounce) const
{
    vec3 radiance(0.0f);
    vec3 throughput(1.0f);
    const auto add = [&](vec3 light, int reflections) {
        radiance += throughput * light;
        if (byBounce == nullptr || light == vec3(0.0f)) return;
        if (byBounce->size() <= std::size_t(reflections)) byBounce->resize(std::size_t(reflections) + 1);
        (*byBounce)[std::size_t(reflections)] += throughput * light;
    };
    for (int depth = 0;; ++depth) {
        if (!at.found()) {
            add(sky_.dimRadiance(direction), depth);
            break;
        }
        // The surface's properties are not needed where the cache has its radiance and it does not emit.
        bool cached = false;
        if (lookup && depth < bounces) {
            const CachedRadiance found = lookup.at({at.face, at.barycentric, direction, at.distance}, bounces - depth);
            cached = found.found;
            if (cached) add(found.radiance, depth + 1);
            if (cached && !found.emissive) break;
        }
        const SurfaceHit hit = tracer_.surfaceAt(at);
        add(weightedEmission(hit, direction, from, directionPdf), depth);
        if (depth >= bounces || cached) break;
        const vec3 albedo = albedoOf(hit.reflectance);

        // Next event: light that reaches this surface directly.
        if (albedo != vec3(0.0f)) {
            vec3 irradiance = punctualIrradiance(hit.point, false, sampler, rays);
            irradiance += emitterIrradiance(hit.point, luminance(irradiance), sampler, rays).irradiance;
            irradiance += skyIrradiance(hit.point, luminance(irradiance), sampler, rays).irradiance;
            add(shading::diffuseRadiance(albedo, irradiance), depth + 1);
        }
        if (glossy()) {
            const SpecularLobe lobe(hit.reflectance, hit.point, direction);
            const SurfaceReflectance& surface = hit.reflectance;
            const float cosine = std::min(std::abs(glm::dot(hit.point.normal, direction)), 1.0f);
            const float probability = shading::specularSamplingShare(surface.baseColor, surface.metallic,
                                                                     surface.roughness, surface.specular, cosine);
            if (sampler.next1() < probability) {
                const Reflection r = reflect(hit, lobe, probability, sampler, rays);
                add(r.lights, depth + 1);
                throughput *= r.throughput;
                if (throughput == vec3(0.0f)) break;
                direction = r.direction;
                directionPdf = r.pdf;
                from = r.from;
                at = r.next;
                continue;
            }
            throughput /= 1.0f - probability;
        }
        if (albedo == vec3(0.0f)) break;
        throughput *= albedo;
        const vec2 uDirection = sampler.next2();
        if (depth > 0 && !survivesRoulette(brightest(throughput), sampler, throughput)) break;
        direction = gatherDirection(hit.point, uDirection);
        directionPdf = gatherPdf(hit.point.normal, direction);
        from = {rayOrigin(hit.point), hit.point.normal};
        ++rays;
        at = tracer_.nearest(from.position, direction, 0.0f, kInfinity);
    }
    return radiance;
}

} // namespace halflight
