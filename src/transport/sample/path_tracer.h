#pragma once
// The path tracer: one estimator of incoming radiance for lightmaps and probes.

#include "transport/sample/emitters.h"
#include "transport/sample/light_reach.h"
#include "transport/sample/lights.h"
#include "transport/sample/sampler.h"
#include "transport/sample/sky_light.h"
#include "transport/sample/specular_lobe.h"
#include "transport/trace/ray_tracer.h"

#include "halflight/scene/scene.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

namespace halflight {

/// Reflected radiance of a hit surface, if the cache has it.
struct CachedRadiance {
    bool found = false;
    bool emissive = false; ///< the surface emits light too, which is not in `radiance`
    vec3 radiance{0.0f};
};
/// The end of a ray that hits a surface.
struct RayEnd {
    FaceId face;
    vec2 barycentric{0.0f};
    vec3 direction{0.0f}; ///< of the ray, unit
    float distance = 0.0f;
};
/// Function that returns the radiance of a hit, back along the ray, after at most `reflections` reflections. Paths end
/// where it is found.
struct RadianceLookup {
    const void* cache = nullptr;
    CachedRadiance (*find)(const void* cache, const RayEnd& end, int reflections) = nullptr;

    explicit operator bool() const { return find != nullptr; }
    [[nodiscard]] CachedRadiance at(const RayEnd& end, int reflections) const { return find(cache, end, reflections); }
};

class PathTracer {
public:
    /// `scene` and `geometry` outlive the tracer.
    PathTracer(const Scene& scene, const BakeGeometry& geometry, LightUse use, Bounces bounces,
               const MakeKernels& makeKernels);

    [[nodiscard]] bool glossy() const { return bounces_ == Bounces::Glossy; }
    /// Albedo of the diffuse part of a surface.
    [[nodiscard]] vec3 albedoOf(const SurfaceReflectance& surface) const
    {
        return glossy() ? surface.diffuseAlbedo() : surface.transportAlbedo();
    }
    [[nodiscard]] bool ok() const { return tracer_.ok(); }
    [[nodiscard]] const RayTracer& surfaces() const { return tracer_; }
    [[nodiscard]] const std::vector<PunctualLight>& lights() const { return lights_; }
    /// Calls visit(light, its index) for the lights whose range may reach a point. The order is always the same.
    template<typename Visit> void forLightsNear(vec3 point, Visit visit) const
    {
        reach_.each(point, [&](uint32_t index) { visit(lights_[index], index); });
    }
    [[nodiscard]] const Emitters& emitters() const { return emitters_; }
    [[nodiscard]] const SkyLight& sky() const { return sky_; }
    /// Whether there are emitters or bright places in the sky, which receivers sample.
    [[nodiscard]] bool samplesEmission() const { return !emitters_.empty() || sky_.samples(); }

    /// Radiance that arrives at `origin` from `direction` after at most `bounces` reflections, without the sky's bright
    /// part where the ray itself leaves the scene.
    struct Incoming {
        vec3 radiance{0.0f};
        bool firstHitBackFace = false;
    };
    /// The ray starts at the receiver's position. `directionPdf`: density of `direction` per steradian, if `receiver`
    /// samples emitters too (the MIS weight of emitter hits), else 0.
    Incoming incoming(const Receiver& receiver, vec3 direction, float directionPdf, int bounces, Sampler& sampler,
                      uint64_t& rays) const;

    /// Radiance that a hit sends back along `direction`, after at most `bounces` reflections. The path ends where
    /// `lookup` has the radiance. `byBounce`, if given, receives the parts of 0, 1, … reflections.
    vec3 pathRadiance(RayHit at, vec3 direction, Receiver from, float directionPdf, int bounces, Sampler& sampler,
                      uint64_t& rays, const RadianceLookup& lookup = {}, std::vector<vec3>* byBounce = nullptr) const;

    /// What a specular lobe sends back along the ray that has hit it.
    struct Reflection {
        vec3 lights{0.0f}; ///< radiance of sampled lights
        vec3 throughput{0.0f};
        vec3 direction{0.0f}; ///< of the ray that goes on
        float pdf = 0.0f;     ///< of the direction, per steradian
        Receiver from;
        RayHit next; ///< where `throughput` is not zero
    };
    /// One sample of the lobe of a hit, over `probability`, that with which the lobe is sampled. Light that arrives is
    /// throughput times the radiance along the next ray, where emission of surfaces has the weight of
    /// weightedEmission(). The ray goes on by Russian roulette.
    Reflection reflect(const SurfaceHit& hit, const SpecularLobe& lobe, float probability, Sampler& sampler,
                       uint64_t& rays) const;

    /// Emission of a hit times its MIS weight beside emitter samples taken at `from`.
    [[nodiscard]] vec3 weightedEmission(const SurfaceHit& hit, vec3 direction, const Receiver& from,
                                        float directionPdf) const;

    /// One emitter sample: irradiance with its MIS weight against cosine-distributed directions, and its direction.
    /// Russian roulette skips emitters that add little to `otherIlluminance` (lux).
    struct EmitterAtSurface {
        vec3 direction{0.0f};
        vec3 irradiance{0.0f};
    };
    /// One sample of the sky's bright part, which rays do not receive: no MIS weight.
    EmitterAtSurface skyIrradiance(const SurfacePoint& point, float otherIlluminance, Sampler& sampler,
                                   uint64_t& rays) const;
    EmitterAtSurface emitterIrradiance(const SurfacePoint& point, float otherIlluminance, Sampler& sampler,
                                       uint64_t& rays) const;
    /// Probability of sampling emitters that give about `emitted` (lux) beside other light (Arvo and Kirk 1990,
    /// "Particle Transport and Image Synthesis").
    static float rouletteSurvival(float emitted, float otherIlluminance)
    {
        constexpr float kLeast = 0.1f; // of the probability, and the share of other light from which on it is 1
        return otherIlluminance > 0.0f ? std::clamp(emitted / (kLeast * otherIlluminance), kLeast, 1.0f) : 1.0f;
    }

    /// A sample among the punctual lights that bounce: a light and a point of the unit disc.
    struct LightChoice {
        const PunctualLight* light = nullptr;
        vec3 unshadowed{0.0f}; ///< irradiance (or what chooseLight() is given) / probability of the light
        vec2 disc{0.0f};

        [[nodiscard]] vec3 irradiance(float transmittance) const
        {
            return light != nullptr ? unshadowed * glm::mix(1.0f, transmittance, light->shadowStrength) : vec3(0.0f);
        }
    };
    /// One light, chosen in proportion to the luminance of contribution(light, disc, probability), which is divided by
    /// `probability`; `disc` is the point of the unit disc that the choice has.
    template<typename Contribution>
    LightChoice chooseLight(const SurfacePoint& point, Sampler& sampler, Contribution contribution) const;
    /// `direct` = without the lights' indirect multipliers.
    LightChoice choosePunctual(const SurfacePoint& point, bool direct, Sampler& sampler) const;
    vec3 punctualIrradiance(const SurfacePoint& point, bool direct, Sampler& sampler, uint64_t& rays) const;
    /// One emitter sample at a point in space: radiance / pdf (per steradian) with its MIS weight, and its direction.
    struct EmitterInSpace {
        vec3 direction{0.0f};
        vec3 radianceOverPdf{0.0f};
    };
    EmitterInSpace emitterInSpace(vec3 position, float directionPdf, Sampler& sampler, uint64_t& rays) const;
    /// The same of the sky's bright part, without a MIS weight.
    EmitterInSpace skyInSpace(vec3 position, Sampler& sampler, uint64_t& rays) const;

    /// Shadow ray from a surface point to a point of a light's disc.
    Ray shadowRay(const PunctualLight& light, const SurfacePoint& point, vec2 disc, uint64_t& rays) const;
    /// Transmittance along such a ray; 1 for lights without shadows.
    float lightVisibility(const PunctualLight& light, const SurfacePoint& point, vec2 disc, uint64_t& rays) const;
    /// The same for a point in space and a ray of sampleLightRay() from there.
    float lightVisibilityInSpace(const PunctualLight& light, vec3 position, const LightRay& ray, uint64_t& rays) const;

    /// Whether the light, the object and the material cast and receive shadows.
    [[nodiscard]] bool shadowsFall(const PunctualLight& light, const SurfacePoint& point) const
    {
        const BakeGeometry& geometry = tracer_.geometry();
        return light.castShadows && geometry.partOf(point.triangle).receiveShadows;
    }

    /// A gather direction about the point's normal: cosine-distributed, reflected out of the surface if below it.
    static vec3 gatherDirection(const SurfacePoint& point, vec2 u);
    /// Its density per steradian; above 0 for reflected directions too.
    static float gatherPdf(vec3 normal, vec3 direction) { return std::max(glm::dot(normal, direction), 1.0e-4f) / kPi; }
    [[nodiscard]] vec3 rayOrigin(const SurfacePoint& point) const;

private:
    vec3 reflectedEmitters(const SurfaceHit& hit, const SpecularLobe& lobe, Sampler& sampler, uint64_t& rays) const;
    vec3 reflectedSky(const SurfaceHit& hit, const SpecularLobe& lobe, Sampler& sampler, uint64_t& rays) const;
    [[nodiscard]] vec3 shadowOrigin(const SurfacePoint& point, uint64_t& rays) const;

    RayTracer tracer_;
    std::vector<PunctualLight> lights_;
    Emitters emitters_;
    LightReach reach_;
    LightTree punctualTree_; ///< of the lights that bounce; empty if they are few
    std::vector<uint32_t> lightOfItem_;
    std::vector<uint32_t> alwaysChosenFrom_; ///< lights that bounce and are not in the tree
    SkyLight sky_;
    Bounces bounces_;
};

// One light per call, chosen in proportion to the unshadowed contributions (Shirley et al. 1996, "Monte Carlo
// Techniques for Direct Lighting Calculations", section 5). The choice is a weighted reservoir of size one (Chao 1982,
// "A General Purpose Unequal Probability Sampling Plan"): each light rescales the random number, so any number of
// lights needs no memory. If lights are many, one point or spot light of the tree enters the reservoir, with
// contribution / probability.
template<typename Contribution> PathTracer::LightChoice
PathTracer::chooseLight(const SurfacePoint& point, Sampler& sampler, Contribution contribution) const
{
    if (lights_.empty()) return {};
    float u = sampler.next1();
    const vec2 disc = shading::sampleDisc(sampler.next2());
    float total = 0.0f;
    float chosenWeight = 0.0f;
    const PunctualLight* chosen = nullptr;
    vec3 chosenContribution(0.0f);
    const auto consider = [&](const PunctualLight& light, float probability) {
        const vec3 unshadowed = contribution(light, disc, probability);
        const float weight = luminance(unshadowed);
        if (weight <= 0.0f) return;
        total += weight;
        const float take = weight / total;
        if (u < take) {
            chosen = &light;
            chosenWeight = weight;
            chosenContribution = unshadowed;
            u /= take;
        } else {
            u = (u - take) / (1.0f - take);
        }
    };
    for (const uint32_t index : alwaysChosenFrom_) consider(lights_[index], 1.0f);
    if (!punctualTree_.empty()) {
        const LightTree::Choice choice = punctualTree_.sample(point.position, point.normal, sampler.next1());
        if (choice.probability > 0.0f) consider(lights_[lightOfItem_[choice.item]], choice.probability);
    }
    if (chosen == nullptr) return {};
    return {chosen, chosenContribution * (total / chosenWeight), disc};
}

} // namespace halflight
