// Camera paths of reference pictures: the BRDF of the first surface, and its estimators.

#include "bake_cpu/sample/path_tracer.h"

#include "halflight/shading/brdf.h"
#include "halflight/shading/sampling.h"
#include "halflight/shading/sky.h"

#include <algorithm>
#include <cmath>

namespace halflight {

/// glTF's BRDF at a point, with importance sampling: directions of the specular lobe with about its share of the
/// reflected light as probability, else cosine-distributed ones.
class PathTracer::CameraBrdf {
public:
    CameraBrdf(const SurfacePoint& point, const SurfaceReflectance& surface, vec3 view)
        : point_(point), surface_(surface), view_(view), nDotV_(std::max(glm::dot(point.normal, view), 1.0e-4f)),
          alpha_(shading::square(std::max(surface.roughness, 0.045f)))
    {
        shading::orthonormalBasis(point.normal, tangent_, bitangent_);
        const vec3 f0 = shading::specularF0Of(surface.baseColor, surface.metallic, surface.specular);
        const float f90 = shading::specularF90Of(surface.metallic, surface.specular);
        const float specular = luminance(shading::environmentSpecular(f0, f90, surface.roughness, nDotV_));
        const float diffuse = luminance(shading::diffuseAlbedoOf(surface.baseColor, surface.metallic));
        constexpr float kLeast = 0.1f; // the estimated share may be wrong, so both lobes keep a probability
        if (!(f90 > 0.0f))
            specularProbability_ = 0.0f;
        else if (!(diffuse > 0.0f))
            specularProbability_ = 1.0f;
        else
            specularProbability_ = std::clamp(specular / (specular + diffuse), kLeast, 1.0f - kLeast);
    }

    /// Radiance towards the view for light from `direction` with this illuminance at normal incidence.
    [[nodiscard]] vec3 reflected(vec3 direction, vec3 illuminance) const
    {
        return shading::reflectLight(surface_.baseColor, surface_.metallic, surface_.roughness, surface_.specular,
                                     point_.normal, view_, direction, illuminance);
    }

    /// A sampled direction. Directions of the specular lobe may point into the surface; their contribution is 0.
    [[nodiscard]] vec3 direction(float uLobe, vec2 u) const
    {
        if (uLobe >= specularProbability_) return gatherDirection(point_, u);
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
        if (specularProbability_ <= 0.0f) return diffuse;
        const float a2 = alpha_ * alpha_;
        const vec3 h = glm::normalize(direction + view_);
        const float d = shading::distributionGgx(shading::saturate(glm::dot(point_.normal, h)), alpha_);
        // D G1(v) / (4 N.v), G1 = 2 N.v / (N.v + sqrt(a2 + (1 - a2) (N.v)^2)).
        const float specular = 0.5f * d / (nDotV_ + std::sqrt(a2 + (1.0f - a2) * nDotV_ * nDotV_));
        return glm::mix(diffuse, specular, specularProbability_);
    }

private:
    const SurfacePoint& point_;
    SurfaceReflectance surface_;
    vec3 view_;
    float nDotV_;
    float alpha_;
    float specularProbability_;
    vec3 tangent_;
    vec3 bitangent_;
};

vec3 PathTracer::punctualRadiance(const SurfacePoint& point, const CameraBrdf& brdf, Sampler& sampler,
                                  uint64_t& rays) const
{
    const LightChoice choice = choosePunctual(point, true, sampler);
    if (choice.light == nullptr) return vec3(0.0f);
    const vec3 direction = choice.light->at(point.position).direction;
    const float cosine = glm::dot(point.normal, direction); // a factor of the choice's irradiance; above 0
    return brdf.reflected(direction, choice.irradiance(lightVisibility(*choice.light, point, choice.disc, rays))) /
           cosine;
}

vec3 PathTracer::emitterRadiance(const SurfacePoint& point, const CameraBrdf& brdf, Sampler& sampler,
                                 uint64_t& rays) const
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
    const float weight = s.rayVisible ? shading::powerHeuristic(pdf, brdf.pdf(direction)) : 1.0f;
    ++rays;
    const float transmittance = tracer_.transmittance(origin, direction, 0.0f, distance * (1.0f - 1.0e-4f));
    return brdf.reflected(direction, s.radiance) * (transmittance * weight / pdf);
}

vec3 PathTracer::cameraRadiance(vec3 origin, vec3 direction, float tMax, int bounces, Sampler& sampler,
                                uint64_t& rays) const
{
    ++rays;
    const RayHit at = tracer_.nearest(origin, direction, 0.0f, tMax, true);
    if (!at.found) return shading::skyRadiance(sky_.zenith, sky_.horizon, sky_.ground, direction);
    const uint32_t triangle = tracer_.triangleOf(at.geomID, at.primID);
    const SurfaceReflectance surface = tracer_.materials().reflectanceAt(triangle, at.barycentric);
    if (tracer_.materials().of(triangle).unlit) return surface.baseColor;
    const SurfaceHit hit = tracer_.surfaceAt(at);
    const CameraBrdf brdf(hit.point, surface, -direction);
    vec3 radiance = hit.emission + punctualRadiance(hit.point, brdf, sampler, rays) +
                    emitterRadiance(hit.point, brdf, sampler, rays);
    const float uLobe = sampler.next1();
    const vec3 onward = brdf.direction(uLobe, sampler.next2());
    if (glm::dot(onward, hit.point.geometricNormal) <= 0.0f) return radiance;
    const float pdf = brdf.pdf(onward);
    const vec3 throughput = brdf.reflected(onward, vec3(1.0f)) / pdf;
    if (throughput == vec3(0.0f)) return radiance;
    const Receiver from{rayOrigin(hit.point), hit.point.normal};
    ++rays;
    const RayHit next = tracer_.nearest(from.position, onward, 0.0f, kInfinity);
    return radiance + throughput * pathRadiance(next, onward, from, pdf, bounces, sampler, rays);
}

} // namespace halflight
