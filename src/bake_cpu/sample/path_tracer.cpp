#include "bake_cpu/sample/path_tracer.h"

#include "bake_cpu/radiosity/radiance_cache.h"

#include "halflight/shading/brdf.h"
#include "halflight/shading/sampling.h"
#include "halflight/shading/sky.h"

#include <algorithm>
#include <cmath>

namespace halflight {

using shading::powerHeuristic;

PathTracer::PathTracer(const Scene& scene, const BakeGeometry& geometry, LightUse use)
    : tracer_(scene, geometry), lights_(punctualLights(scene, use)), emitters_(tracer_), sky_(scene.sky)
{
    // A few lights are faster looked at one by one, and then chosen exactly.
    constexpr std::ptrdiff_t kFewLights = 8;
    if (std::count_if(lights_.begin(), lights_.end(), [](const PunctualLight& l) { return l.bounces; }) > kFewLights) {
        punctualTree_ = punctualTree(lights_, lightOfItem_);
    }
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
    // Smooth normals reach below their triangle: what would start inside the surface is mirrored out of it.
    const float side = glm::dot(direction, point.geometricNormal);
    if (side < 0.0f) direction -= 2.0f * side * point.geometricNormal;
    return direction;
}

// Shadow rays from a low-poly round surface start on the curved surface its normals describe, not on the flat triangle,
// so that the terminator does not show the triangles: Hanika 2021, "Hacking the Shadow Terminator" (Ray Tracing Gems
// II, chapter 4).
static vec3 smoothOrigin(const BakeGeometry& geometry, const SurfacePoint& point)
{
    const uvec3 t = geometry.triangles[point.triangle];
    const float weights[3] = {1.0f - point.barycentric.x - point.barycentric.y, point.barycentric.x,
                              point.barycentric.y};
    if (geometry.normals[t.x] == geometry.normals[t.y] && geometry.normals[t.x] == geometry.normals[t.z]) {
        return point.position;
    }
    const bool flipped = glm::dot(geometry.geometricNormal(point.triangle), point.geometricNormal) < 0.0f;
    vec3 position = point.position;
    for (int i = 0; i < 3; ++i) {
        const vec3 n = flipped ? -geometry.normals[t[i]] : geometry.normals[t[i]];
        if (glm::dot(n, point.geometricNormal) <= 0.0f) return point.position;
        const float below = std::min(0.0f, glm::dot(point.position - geometry.positions[t[i]], n));
        position -= weights[i] * below * n;
    }
    return position;
}

vec3 PathTracer::shadowOrigin(const SurfacePoint& point, uint64_t& rays) const
{
    const float epsilon = tracer_.epsilonAt(point.position);
    const vec3 flat = point.position + point.geometricNormal * epsilon;
    const vec3 origin = smoothOrigin(tracer_.geometry(), point) + point.geometricNormal * epsilon;
    // Not through whatever stands next to the surface.
    const float lift = glm::distance(flat, origin);
    if (lift <= 4.0f * epsilon) return origin;
    ++rays;
    return tracer_.occluded(flat, (origin - flat) / lift, 0.0f, lift) ? flat : origin;
}

PathTracer::ShadowRay PathTracer::shadowRay(const PunctualLight& light, const SurfacePoint& point, vec2 disc,
                                            uint64_t& rays) const
{
    const vec3 origin = shadowOrigin(point, rays);
    const LightRay ray = sampleLightRay(light, origin, disc);
    ++rays;
    return {origin, ray.direction, tracer_.epsilonAt(point.position), ray.distance * (1.0f - 1.0e-4f)};
}

float PathTracer::lightVisibility(const PunctualLight& light, const SurfacePoint& point, vec2 disc,
                                  uint64_t& rays) const
{
    if (!shadowsFall(light, point)) return 1.0f;
    const ShadowRay ray = shadowRay(light, point, disc, rays);
    return tracer_.transmittance(ray.origin, ray.direction, ray.tMin, ray.tMax);
}

float PathTracer::lightVisibilityInSpace(const PunctualLight& light, vec3 position, vec2 u, uint64_t& rays) const
{
    if (!light.castShadows) return 1.0f;
    const LightRay ray = sampleLightRay(light, position, shading::sampleDisc(u));
    ++rays;
    return tracer_.transmittance(position, ray.direction, 0.0f, ray.distance * (1.0f - 1.0e-4f));
}

// One light per call, chosen in proportion to what each would contribute unshadowed (Shirley et al. 1996, "Monte Carlo
// Techniques for Direct Lighting Calculations", section 5); the estimate is contribution / probability. The choice is a
// weighted reservoir of one (Chao 1982, "A General Purpose Unequal Probability Sampling Plan"), its random number used
// up and stretched again at each light, so any number of lights needs no memory. Where lights are many, one of them,
// chosen by the tree, stands for all point and spot lights: its contribution over its probability.
PathTracer::LightChoice PathTracer::choosePunctual(const SurfacePoint& point, bool direct, Sampler& sampler) const
{
    if (lights_.empty()) return {};
    float u = sampler.next1();
    const vec2 uLight = sampler.next2();
    float total = 0.0f;
    float chosenWeight = 0.0f;
    const PunctualLight* chosen = nullptr;
    vec3 contribution(0.0f);
    const auto consider = [&](const PunctualLight& light, float probability) {
        const shading::LightSample s = light.at(point.position);
        const float cosine = glm::dot(point.normal, s.direction);
        if (cosine <= 0.0f) return;
        const vec3 unshadowed = s.illuminance * (cosine * (direct ? 1.0f : light.indirectMultiplier) / probability);
        const float weight = luminance(unshadowed);
        if (weight <= 0.0f) return;
        total += weight;
        const float take = weight / total;
        if (u < take) {
            chosen = &light;
            chosenWeight = weight;
            contribution = unshadowed;
            u /= take;
        } else {
            u = (u - take) / (1.0f - take);
        }
    };
    for (const PunctualLight& light : lights_) {
        if (light.bounces && (punctualTree_.empty() || light.type == shading::kLightDirectional)) consider(light, 1.0f);
    }
    if (!punctualTree_.empty()) {
        const LightTree::Choice choice = punctualTree_.sample(point.position, point.normal, sampler.next1());
        if (choice.probability > 0.0f) consider(lights_[lightOfItem_[choice.item]], choice.probability);
    }
    if (chosen == nullptr) return {};
    return {chosen, contribution * (total / chosenWeight), shading::sampleDisc(uLight)};
}

vec3 PathTracer::punctualIrradiance(const SurfacePoint& point, bool direct, Sampler& sampler, uint64_t& rays) const
{
    const LightChoice choice = choosePunctual(point, direct, sampler);
    if (choice.light == nullptr) return vec3(0.0f);
    return choice.irradiance(lightVisibility(*choice.light, point, choice.disc, rays));
}

PathTracer::EmitterAtSurface PathTracer::emitterIrradiance(const SurfacePoint& point, float beside, Sampler& sampler,
                                                           uint64_t& rays) const
{
    if (emitters_.empty()) return {};
    const Receiver receiver{rayOrigin(point), point.normal};
    const float chance =
        beside > 0.0f ? rouletteSurvival(emitters_.unshadowed(receiver.position, receiver.normal), beside) : 1.0f;
    if (chance < 1.0f && sampler.next1() >= chance) return {};
    const EmitterSample s = emitters_.sample(receiver.position, receiver.normal, sampler.next2());
    const NextEventContribution way = s.from(receiver.position, receiver.normal, point.geometricNormal);
    if (way.distance <= 0.0f || s.radiance == vec3(0.0f)) return {};
    ++rays;
    const float transmittance =
        tracer_.transmittance(receiver.position, way.direction, 0.0f, way.distance * (1.0f - 1.0e-4f));
    if (transmittance <= 0.0f) return {};
    return {way.direction, s.radiance * (transmittance * way.share / chance)};
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
    result.firstHitBackFace = tracer_.metHiddenBack(at);
    result.radiance = follow(at, direction, receiver, directionPdf, bounces, sampler, rays);
    return result;
}

// The BRDF of a point as a camera sees it, and its directions: from the specular lobe with a chance of about its share
// of the reflected light, else cosine-distributed.
class PathTracer::Gloss {
public:
    Gloss(const SurfacePoint& point, const SurfaceReflectance& surface, vec3 view)
        : point_(point), surface_(surface), view_(view), nDotV_(std::max(glm::dot(point.normal, view), 1.0e-4f)),
          alpha_(shading::square(std::max(surface.roughness, 0.045f)))
    {
        shading::orthonormalBasis(point.normal, tangent_, bitangent_);
        const vec3 f0 = shading::specularF0Of(surface.baseColor, surface.metallic, surface.specular);
        const float f90 = shading::specularF90Of(surface.metallic, surface.specular);
        const float specular = luminance(shading::environmentSpecular(f0, f90, surface.roughness, nDotV_));
        const float diffuse = luminance(shading::diffuseAlbedoOf(surface.baseColor, surface.metallic));
        constexpr float kLeast = 0.1f; // neither lobe is left out for a wrong guess
        if (!(f90 > 0.0f))
            specularChance_ = 0.0f;
        else if (!(diffuse > 0.0f))
            specularChance_ = 1.0f;
        else
            specularChance_ = std::clamp(specular / (specular + diffuse), kLeast, 1.0f - kLeast);
    }

    /// Radiance towards the view of light from a direction, of this illuminance on a surface that faces it.
    [[nodiscard]] vec3 reflected(vec3 direction, vec3 illuminance) const
    {
        return shading::reflectLight(surface_.baseColor, surface_.metallic, surface_.roughness, surface_.specular,
                                     point_.normal, view_, direction, illuminance);
    }

    /// A direction; those of the lobe can lead into the surface, and count for nothing there.
    [[nodiscard]] vec3 direction(float uLobe, vec2 u) const
    {
        if (uLobe >= specularChance_) return gatherDirection(point_, u);
        // Dupuy and Benyoub 2023, "Sampling Visible GGX Normals with Spherical Caps".
        const vec3 v(glm::dot(view_, tangent_), glm::dot(view_, bitangent_), nDotV_);
        const vec3 stretched = glm::normalize(vec3(alpha_ * v.x, alpha_ * v.y, v.z));
        const float phi = 2.0f * kPi * u.x;
        const float z = 1.0f - u.y * (1.0f + stretched.z);
        const float sine = std::sqrt(std::clamp(1.0f - z * z, 0.0f, 1.0f));
        const vec3 cap = vec3(sine * std::cos(phi), sine * std::sin(phi), z) + stretched;
        const vec3 h = glm::normalize(vec3(alpha_ * cap.x, alpha_ * cap.y, std::max(cap.z, 1.0e-6f)));
        const vec3 local = 2.0f * glm::dot(v, h) * h - v;
        return glm::normalize(local.x * tangent_ + local.y * bitangent_ + local.z * point_.normal);
    }

    /// Density of direction(), per steradian.
    [[nodiscard]] float pdf(vec3 direction) const
    {
        const float diffuse = gatherPdf(point_.normal, direction);
        if (specularChance_ <= 0.0f) return diffuse;
        const float a2 = alpha_ * alpha_;
        const vec3 h = glm::normalize(direction + view_);
        const float d = shading::distributionGgx(shading::saturate(glm::dot(point_.normal, h)), alpha_);
        // D G1(v) / (4 N.v), G1 = 2 N.v / (N.v + sqrt(a2 + (1 - a2) (N.v)^2)).
        const float specular = 0.5f * d / (nDotV_ + std::sqrt(a2 + (1.0f - a2) * nDotV_ * nDotV_));
        return glm::mix(diffuse, specular, specularChance_);
    }

private:
    const SurfacePoint& point_;
    SurfaceReflectance surface_;
    vec3 view_;
    float nDotV_;
    float alpha_;
    float specularChance_;
    vec3 tangent_;
    vec3 bitangent_;
};

vec3 PathTracer::punctualRadiance(const SurfacePoint& point, const Gloss& gloss, Sampler& sampler, uint64_t& rays) const
{
    const LightChoice choice = choosePunctual(point, true, sampler);
    if (choice.light == nullptr) return vec3(0.0f);
    const vec3 direction = choice.light->at(point.position).direction;
    const float cosine = glm::dot(point.normal, direction); // in what is unshadowed already; above 0
    return gloss.reflected(direction, choice.irradiance(lightVisibility(*choice.light, point, choice.disc, rays))) /
           cosine;
}

vec3 PathTracer::emitterRadiance(const SurfacePoint& point, const Gloss& gloss, Sampler& sampler, uint64_t& rays) const
{
    if (emitters_.empty()) return vec3(0.0f);
    const vec3 origin = rayOrigin(point);
    const EmitterSample s = emitters_.sample(origin, point.normal, sampler.next2());
    const vec3 way = s.position - origin;
    const float distance2 = glm::dot(way, way);
    if (s.pdfArea <= 0.0f || s.radiance == vec3(0.0f) || distance2 <= 0.0f) return vec3(0.0f);
    const float distance = std::sqrt(distance2);
    const vec3 direction = way / distance;
    const float front = -glm::dot(s.normal, direction);
    const float emitterCosine = s.doubleSided ? std::abs(front) : front;
    if (emitterCosine <= 0.0f || glm::dot(direction, point.geometricNormal) <= 0.0f) return vec3(0.0f);
    const float pdf = s.pdfArea * distance2 / emitterCosine;
    const float weight = s.rayVisible ? powerHeuristic(pdf, gloss.pdf(direction)) : 1.0f;
    ++rays;
    const float transmittance = tracer_.transmittance(origin, direction, 0.0f, distance * (1.0f - 1.0e-4f));
    return gloss.reflected(direction, s.radiance) * (transmittance * weight / pdf);
}

vec3 PathTracer::seenFromCamera(vec3 origin, vec3 direction, float tMax, int bounces, Sampler& sampler,
                                uint64_t& rays) const
{
    ++rays;
    const RayHit at = tracer_.nearest(origin, direction, 0.0f, tMax, true);
    if (!at.found) return shading::skyRadiance(sky_.zenith, sky_.horizon, sky_.ground, direction);
    const uint32_t triangle = tracer_.triangleOf(at.geomID, at.primID);
    const SurfaceReflectance surface = tracer_.reflectanceAt(triangle, at.barycentric);
    if (tracer_.materialOfTriangle(triangle).unlit) return surface.baseColor;
    const SurfaceHit hit = tracer_.surfaceAt(at);
    const Gloss gloss(hit.point, surface, -direction);
    vec3 radiance = hit.emission + punctualRadiance(hit.point, gloss, sampler, rays) +
                    emitterRadiance(hit.point, gloss, sampler, rays);
    const float uLobe = sampler.next1();
    const vec3 onward = gloss.direction(uLobe, sampler.next2());
    if (glm::dot(onward, hit.point.geometricNormal) <= 0.0f) return radiance;
    const float pdf = gloss.pdf(onward);
    const vec3 throughput = gloss.reflected(onward, vec3(1.0f)) / pdf;
    if (throughput == vec3(0.0f)) return radiance;
    const Receiver from{rayOrigin(hit.point), hit.point.normal};
    ++rays;
    const RayHit next = tracer_.nearest(from.position, onward, 0.0f, kInfinity);
    return radiance + throughput * follow(next, onward, from, pdf, bounces, sampler, rays);
}

// Kajiya 1986, "The Rendering Equation", for diffuse surfaces: the throughput of a cosine-distributed bounce is the
// albedo.
vec3 PathTracer::follow(RayHit at, vec3 direction, Receiver from, float directionPdf, int bounces, Sampler& sampler,
                        uint64_t& rays, const RadianceCache* cache, vec3* byBounce) const
{
    vec3 radiance(0.0f);
    vec3 throughput(1.0f);
    const auto add = [&](vec3 light, int reflections) {
        radiance += throughput * light;
        if (byBounce != nullptr) byBounce[reflections] += throughput * light;
    };
    for (int depth = 0;; ++depth) {
        if (!at.found) {
            add(shading::skyRadiance(sky_.zenith, sky_.horizon, sky_.ground, direction), depth);
            break;
        }
        // Where the cache knows all, there is no need to look at the surface.
        vec3 known;
        bool isKnown = false;
        if (cache != nullptr && depth < bounces) {
            const uint32_t record = RadianceCache::recordOf(tracer_.hitIndex(at.geomID, at.primID), at.behind);
            isKnown = cache->reflected(record, at.barycentric, at.distance, bounces - depth, known);
            if (isKnown) add(known, depth + 1);
            if (isKnown && !cache->emissive(record)) break;
        }
        const SurfaceHit hit = tracer_.surfaceAt(at);
        add(weightedEmission(hit, direction, from, directionPdf), depth);
        if (depth >= bounces || isKnown || hit.albedo == vec3(0.0f)) break;

        // Light that reaches this surface directly.
        vec3 irradiance = punctualIrradiance(hit.point, false, sampler, rays);
        irradiance += emitterIrradiance(hit.point, luminance(irradiance), sampler, rays).irradiance;
        add(shading::diffuseRadiance(hit.albedo, irradiance), depth + 1);

        // Russian roulette (Arvo and Kirk 1990) once a path has lost most of its light; of paths that end in a cache,
        // where they met something dark first.
        throughput *= hit.albedo;
        const vec2 uDirection = sampler.next2();
        constexpr float kFirst = 1.4f;
        const bool first = depth == 0;
        const float survival = (first ? kFirst : 1.0f) * std::max({throughput.x, throughput.y, throughput.z});
        if ((!first || cache != nullptr) && survival < 0.7f) {
            if (sampler.next1() >= survival) break;
            throughput /= survival;
        }
        direction = gatherDirection(hit.point, uDirection);
        directionPdf = gatherPdf(hit.point.normal, direction);
        from = {rayOrigin(hit.point), hit.point.normal};
        ++rays;
        at = tracer_.nearest(from.position, direction, 0.0f, kInfinity);
    }
    return radiance;
}

} // namespace halflight
