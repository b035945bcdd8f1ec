#include "transport/sample/path_tracer.h"

#include "halflight/shading/brdf.h"

#include <algorithm>
#include <cmath>

namespace halflight {

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

PathTracer::Reflection PathTracer::reflect(const SurfaceHit& hit, const SpecularLobe& lobe, float probability,
                                           Sampler& sampler, uint64_t& rays) const
{
    Reflection result;
    const SceneLight::LightChoice choice =
        light_.chooseLight(hit.point, sampler, [&](const PunctualLight& light, vec2 disc, float probability) {
            const float scale = light.indirectMultiplier / probability;
            const LightRay ray = sampleLightRay(light, hit.point.position, disc);
            if (light.isArea())
                return lobe.reflected(ray.direction, light.radianceAt(hit.point.position) * (ray.solidAngle * scale));
            return lobe.reflected(ray.direction, light.at(hit.point.position).illuminance * scale);
        });
    if (choice.light != nullptr)
        result.lights = choice.irradiance(direct_.lightVisibility(*choice.light, hit.point, choice.disc, rays));
    result.lights +=
        direct_.reflectedEmitters(hit, lobe, sampler, rays) + direct_.reflectedSky(hit, lobe, sampler, rays);
    result.lights /= probability;
    result.direction = lobe.sample(sampler.next2());
    if (result.direction == vec3(0.0f)) return result;
    result.pdf = lobe.pdf(result.direction);
    const vec3 throughput = lobe.reflected(result.direction, vec3(1.0f / (result.pdf * probability)));
    const float survival = std::min(brightest(throughput), 1.0f);
    if (!(survival > 0.0f) || !(sampler.next1() < survival)) return result;
    result.throughput = throughput / survival;
    result.from = {tracer_.rayOrigin(hit.point), hit.point.normal};
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
        throughput *= at.tint;
        if (!at.found()) {
            add(light_.sky().dimRadiance(direction), depth);
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
        add(direct_.weightedEmission(hit, direction, from, directionPdf), depth);
        if (depth >= bounces || cached) break;
        const vec3 albedo = albedoOf(hit.reflectance);

        // Next event: light that reaches this surface directly.
        if (albedo != vec3(0.0f)) {
            vec3 irradiance = direct_.punctualIrradiance(hit.point, false, sampler, rays);
            irradiance += direct_.emitterIrradiance(hit.point, luminance(irradiance), sampler, rays).irradiance;
            irradiance += direct_.skyIrradiance(hit.point, luminance(irradiance), sampler, rays).irradiance;
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
        from = {tracer_.rayOrigin(hit.point), hit.point.normal};
        ++rays;
        at = tracer_.nearest(from.position, direction, 0.0f, kInfinity);
    }
    return radiance;
}

} // namespace halflight
