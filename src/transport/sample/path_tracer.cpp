#include "transport/sample/path_tracer.h"

#include "halflight/shading/brdf.h"

#include <algorithm>
#include <cmath>

namespace halflight {
namespace {

/// Probability with which a path goes on by the specular lobe of a hit.
float specularShare(const SurfaceHit& hit, vec3 direction)
{
    const SurfaceReflectance& surface = hit.reflectance;
    const float cosine = std::min(std::abs(glm::dot(hit.point.normal, direction)), 1.0f);
    return shading::specularSamplingShare(surface.baseColor, surface.metallic, surface.roughness, surface.specular,
                                          cosine);
}

} // namespace

PathTracer::Incoming PathTracer::incoming(const Receiver& receiver, vec3 direction, float directionPdf, int bounces,
                                          Sampler& sampler, uint64_t& rays, PathLights* lights) const
{
    ++rays;
    const RayHit at = tracer_.nearest(receiver.position, direction, 0.0f, kInfinity);
    Incoming result;
    result.firstHitBackFace = tracer_.hitHiddenBack(at);
    result.radiance = pathRadiance(at, direction, receiver, directionPdf, bounces, sampler, rays, {}, nullptr, lights);
    return result;
}

PathTracer::Reflection PathTracer::reflect(const SurfaceHit& hit, const SpecularLobe& lobe, float probability,
                                           Sampler& sampler, uint64_t& rays, SampledLights* ofLights) const
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
    const vec3 lamp = result.lights;
    const vec3 sky = direct_.reflectedSky(hit, lobe, sampler, rays);
    const DirectLight::Reflected emitter = direct_.reflectedEmitters(hit, lobe, sampler, rays);
    result.lights += emitter.radiance + sky;
    result.lights /= probability;
    if (ofLights != nullptr)
        *ofLights = {{{lamp / probability, choice.light != nullptr ? choice.light->component : 0},
                      {emitter.radiance / probability, emitter.component},
                      {sky / probability, light_.skyComponent()}}};
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

/// Components have no roulette: beside others' light, that of a dim one would be noise.
vec3 PathTracer::reflectDiffusely(const SurfacePoint& point, vec3 albedo, Sampler& sampler, uint64_t& rays,
                                  SampledLights* ofLights) const
{
    const auto otherLight = [&](vec3 irradiance) { return ofLights != nullptr ? 0.0f : luminance(irradiance); };
    const DirectLight::OfLight lamp = direct_.punctualIrradiance(point, false, sampler, rays);
    vec3 irradiance = lamp.irradiance;
    const auto emitter = direct_.emitterIrradiance(point, otherLight(irradiance), sampler, rays);
    irradiance += emitter.irradiance;
    const auto sky = direct_.skyIrradiance(point, otherLight(irradiance), sampler, rays);
    irradiance += sky.irradiance;
    if (ofLights != nullptr)
        *ofLights = {{{shading::diffuseRadiance(albedo, lamp.irradiance), lamp.component},
                      {shading::diffuseRadiance(albedo, emitter.irradiance), emitter.component},
                      {shading::diffuseRadiance(albedo, sky.irradiance), sky.component}}};
    return shading::diffuseRadiance(albedo, irradiance);
}

void PathTracer::noteCached(const RadianceLookup& lookup, const RayEnd& end, int reflections, vec3 throughput,
                            int before, PathLights& lights) const
{
    std::array<vec3, kMostLightGroups + 1> found;
    const auto components = std::size_t(light_.components());
    lookup.findComponents(lookup.cache, end, reflections, std::span(found).first(components));
    for (std::size_t c = 0; c < components; ++c)
        if (found[c] != vec3(0.0f)) lights.push_back({int(c), before, throughput * found[c]});
}

// Path tracing (Kajiya 1986, "The Rendering Equation"). At each surface the path goes on by the diffuse part, whose
// throughput is the albedo because directions are cosine-distributed, or by the specular lobe.
vec3 PathTracer::pathRadiance(RayHit at, vec3 direction, Receiver from, float directionPdf, int bounces,
                              Sampler& sampler, uint64_t& rays, const RadianceLookup& lookup,
                              std::vector<vec3>* byBounce, PathLights* lights) const
{
    vec3 radiance(0.0f);
    vec3 throughput(1.0f);
    const auto add = [&](vec3 light, int reflections) {
        radiance += throughput * light;
        if (byBounce == nullptr || light == vec3(0.0f)) return;
        if (byBounce->size() <= std::size_t(reflections)) byBounce->resize(std::size_t(reflections) + 1);
        (*byBounce)[std::size_t(reflections)] += throughput * light;
    };
    const auto note = [&](int component, vec3 light, int reflections) {
        if (lights != nullptr && light != vec3(0.0f)) lights->push_back({component, reflections, throughput * light});
    };
    SampledLights sampled;
    SampledLights* const ofLights = lights != nullptr ? &sampled : nullptr;
    const auto noteAll = [&](int reflections) {
        if (lights == nullptr) return;
        for (const DirectLight::Reflected& light : sampled) note(light.component, light.radiance, reflections);
    };
    for (int depth = 0;; ++depth) {
        throughput *= at.tint;
        if (!at.found()) {
            const vec3 sky = light_.sky().dimRadiance(direction);
            add(sky, depth);
            light_.splitSky(direction, sky, [&](int component, vec3 part) { note(component, part, depth); });
            break;
        }
        // The surface's properties are not needed where the cache has its radiance and it does not emit.
        bool cached = false;
        if (lookup && depth < bounces) {
            const RayEnd end{at.face, at.barycentric, direction, at.distance};
            const CachedRadiance found = lookup.at(end, bounces - depth);
            cached = found.found;
            if (cached) add(found.radiance, depth + 1);
            if (cached && lights != nullptr) noteCached(lookup, end, bounces - depth, throughput, depth + 1, *lights);
            if (cached && !found.emissive) break;
        }
        const SurfaceHit hit = tracer_.surfaceAt(at);
        const vec3 emission = direct_.weightedEmission(hit, direction, from, directionPdf);
        add(emission, depth);
        if (lights != nullptr) note(light_.emissionComponent(hit.point.triangle), emission, depth);
        if (depth >= bounces || cached) break;
        const vec3 albedo = albedoOf(hit.reflectance);

        // Next event: light that reaches this surface directly.
        if (albedo != vec3(0.0f)) {
            add(reflectDiffusely(hit.point, albedo, sampler, rays, ofLights), depth + 1);
            noteAll(depth + 1);
        }
        if (glossy()) {
            const SpecularLobe lobe(hit.reflectance, hit.point, direction);
            const float probability = specularShare(hit, direction);
            if (sampler.next1() < probability) {
                const Reflection r = reflect(hit, lobe, probability, sampler, rays, ofLights);
                add(r.lights, depth + 1);
                noteAll(depth + 1);
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
