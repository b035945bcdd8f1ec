#pragma once
// Samples of the light that reaches a point directly.

#include "transport/sample/scene_light.h"
#include "transport/sample/specular_lobe.h"

namespace halflight {

/// Estimates of direct light, one sample and at most one shadow ray each. `rays` counts the rays.
class DirectLight {
public:
    /// Both outlive it.
    DirectLight(const RayTracer& surfaces, const SceneLight& light) : tracer_(surfaces), light_(light) {}

    /// One light's, chosen as SceneLight::choosePunctual() does, with one shadow ray.
    struct OfLight {
        vec3 irradiance{0.0f};
        int component = 0;
    };
    OfLight punctualIrradiance(const SurfacePoint& point, bool direct, Sampler& sampler, uint64_t& rays) const;
    /// One emitter sample: irradiance with its MIS weight against cosine-distributed directions, and its direction.
    /// Russian roulette skips emitters that add little to `otherIlluminance` (lux).
    struct EmitterAtSurface {
        vec3 direction{0.0f};
        vec3 irradiance{0.0f};
        int component = 0;
    };
    /// One sample of the sky's bright part, which rays do not receive: no MIS weight.
    EmitterAtSurface skyIrradiance(const SurfacePoint& point, float otherIlluminance, Sampler& sampler,
                                   uint64_t& rays) const;
    EmitterAtSurface emitterIrradiance(const SurfacePoint& point, float otherIlluminance, Sampler& sampler,
                                       uint64_t& rays) const;
    /// One emitter sample at a point in space: radiance / pdf (per steradian) with its MIS weight, and its direction.
    struct EmitterInSpace {
        vec3 direction{0.0f};
        vec3 radianceOverPdf{0.0f};
        int component = 0;
    };
    EmitterInSpace emitterInSpace(vec3 position, float directionPdf, Sampler& sampler, uint64_t& rays) const;
    /// The same of the sky's bright part, without a MIS weight.
    EmitterInSpace skyInSpace(vec3 position, Sampler& sampler, uint64_t& rays) const;

    /// Radiance that the specular lobe of a hit reflects of one emitter sample, and of one of the sky's bright part.
    struct Reflected {
        vec3 radiance{0.0f};
        int component = 0;
    };
    Reflected reflectedEmitters(const SurfaceHit& hit, const SpecularLobe& lobe, Sampler& sampler,
                                uint64_t& rays) const;
    vec3 reflectedSky(const SurfaceHit& hit, const SpecularLobe& lobe, Sampler& sampler, uint64_t& rays) const;

    /// Emission of a hit times its MIS weight beside emitter samples taken at `from`.
    [[nodiscard]] vec3 weightedEmission(const SurfaceHit& hit, vec3 direction, const Receiver& from,
                                        float directionPdf) const;

    /// Shadow ray from a surface point to a point of a light's disc.
    Ray shadowRay(const PunctualLight& light, const SurfacePoint& point, vec2 disc, uint64_t& rays) const;
    /// Transmittance along such a ray; 1 for lights without shadows.
    vec3 lightVisibility(const PunctualLight& light, const SurfacePoint& point, vec2 disc, uint64_t& rays) const;
    /// The same for a point in space and a ray of sampleLightRay() from there.
    vec3 lightVisibilityInSpace(const PunctualLight& light, vec3 position, const LightRay& ray, uint64_t& rays) const;

    /// Whether the light, the object and the material cast and receive shadows.
    [[nodiscard]] bool shadowsFall(const PunctualLight& light, const SurfacePoint& point) const
    {
        return light.castShadows != 0 && tracer_.geometry().partOf(point.triangle).receiveShadows;
    }

private:
    [[nodiscard]] vec3 shadowOrigin(const SurfacePoint& point, uint64_t& rays) const;

    const RayTracer& tracer_;
    const SceneLight& light_;
};

} // namespace halflight
