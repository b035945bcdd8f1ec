#pragma once
// The path tracer: one estimator of incoming radiance, used by lightmap, probes and reference pictures.

#include "bake_cpu/sample/lights.h"
#include "bake_cpu/sample/sampler.h"
#include "bake_cpu/trace/ray_tracer.h"

#include "halflight/scene/scene.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

namespace halflight {

class RadianceCache;

class PathTracer {
public:
    /// `scene` and `geometry` outlive the tracer.
    PathTracer(const Scene& scene, const BakeGeometry& geometry, LightUse use);

    [[nodiscard]] bool ok() const { return tracer_.ok(); }
    [[nodiscard]] const RayTracer& surfaces() const { return tracer_; }
    [[nodiscard]] const std::vector<PunctualLight>& lights() const { return lights_; }
    [[nodiscard]] const Emitters& emitters() const { return emitters_; }
    [[nodiscard]] const Sky& sky() const { return sky_; }

    /// Radiance that arrives at `origin` from `direction` after at most `bounces` reflections.
    struct Incoming {
        vec3 radiance{0.0f};
        bool firstHitBackFace = false;
    };
    /// directionPdf: density per steradian with which `direction` was chosen when emitters were sampled for `receiver`
    /// too (their hits are then weighted), 0 when they were not. The ray starts at the receiver's position.
    Incoming incoming(const Receiver& receiver, vec3 direction, float directionPdf, int bounces, Sampler& sampler,
                      uint64_t& rays) const;

    /// Radiance that a hit sends back along `direction`, of at most `bounces` reflections. With a cache, paths end
    /// where it knows the answer. `byBounce`, if given, receives the parts of 0, 1, 2, … reflections (bounces + 1 of
    /// them).
    vec3 follow(RayHit at, vec3 direction, Receiver from, float directionPdf, int bounces, Sampler& sampler,
                uint64_t& rays, const RadianceCache* cache = nullptr, vec3* byBounce = nullptr) const;

    /// Emission of a hit as it counts beside emitter samples taken at `from`.
    [[nodiscard]] vec3 weightedEmission(const SurfaceHit& hit, vec3 direction, const Receiver& from,
                                        float directionPdf) const;

    /// Radiance that leaves a surface seen from a camera, linear: glTF's BRDF there (shading/brdf.h, without normal
    /// maps), diffuse surfaces of shading::transportAlbedo() from the first bounce on. `origin` is in front of whatever
    /// is to be seen.
    vec3 seenFromCamera(vec3 origin, vec3 direction, float tMax, int bounces, Sampler& sampler, uint64_t& rays) const;

    /// Irradiance from emissive triangles, one sample, weighted against cosine-distributed directions; the direction
    /// is that of the emitter's point. Where they can add only little beside light of luminance `beside` (lux), most
    /// calls look at none, and the others count for them.
    struct EmitterAtSurface {
        vec3 direction{0.0f};
        vec3 irradiance{0.0f};
    };
    EmitterAtSurface emitterIrradiance(const SurfacePoint& point, float beside, Sampler& sampler, uint64_t& rays) const;
    /// With what probability to look at emitters that give about `emitted` (lux) beside other light (Russian roulette:
    /// Arvo and Kirk 1990, "Particle Transport and Image Synthesis").
    static float rouletteSurvival(float emitted, float beside)
    {
        constexpr float kLittle = 0.1f;
        return beside > 0.0f ? std::clamp(emitted / (kLittle * beside), 1.0f / 8.0f, 1.0f) : 1.0f;
    }

    /// One of the lights that bounce, if any reaches a point, and where on its disc to look.
    struct LightChoice {
        const PunctualLight* light = nullptr;
        vec3 unshadowed{0.0f}; ///< irradiance over the probability of the choice
        vec2 disc{0.0f};

        /// `share`: what of its light arrives.
        [[nodiscard]] vec3 irradiance(float share) const
        {
            return light != nullptr ? unshadowed * glm::mix(1.0f, share, light->shadowStrength) : vec3(0.0f);
        }
    };
    LightChoice choosePunctual(const SurfacePoint& point, bool direct, Sampler& sampler) const;
    vec3 punctualIrradiance(const SurfacePoint& point, bool direct, Sampler& sampler, uint64_t& rays) const;
    /// A sampled emitter seen from a point in space: radiance over pdf (per steradian), with its direction.
    struct EmitterInSpace {
        vec3 direction{0.0f};
        vec3 radianceOverPdf{0.0f};
    };
    EmitterInSpace emitterInSpace(vec3 position, float directionPdf, Sampler& sampler, uint64_t& rays) const;

    /// A ray from a surface point to a place on a light's disc.
    struct ShadowRay {
        vec3 origin;
        vec3 direction;
        float tMin;
        float tMax;
    };
    ShadowRay shadowRay(const PunctualLight& light, const SurfacePoint& point, vec2 disc, uint64_t& rays) const;
    /// What of the light that such a ray looks at arrives: 0…1, 1 of lights without shadows.
    float lightVisibility(const PunctualLight& light, const SurfacePoint& point, vec2 disc, uint64_t& rays) const;
    /// The same from a point in space, along one sampled ray.
    float lightVisibilityInSpace(const PunctualLight& light, vec3 position, vec2 u, uint64_t& rays) const;

    /// Whether shadows of the light fall on a point: they do by the light's, the object's and the material's switches.
    [[nodiscard]] bool shadowsFall(const PunctualLight& light, const SurfacePoint& point) const
    {
        const BakeGeometry& geometry = tracer_.geometry();
        return light.castShadows && geometry.parts[geometry.partOfTriangle[point.triangle]].receiveShadows;
    }

    /// Where shadow rays leave a surface point.
    [[nodiscard]] vec3 shadowOrigin(const SurfacePoint& point, uint64_t& rays) const;

    /// A gather direction around the point's normal, cosine-distributed, never below the surface.
    static vec3 gatherDirection(const SurfacePoint& point, vec2 u);
    /// Its density, per steradian: above zero for directions that were mirrored out of the surface too.
    static float gatherPdf(vec3 normal, vec3 direction) { return std::max(glm::dot(normal, direction), 1.0e-4f) / kPi; }
    [[nodiscard]] vec3 rayOrigin(const SurfacePoint& point) const;

private:
    class Gloss;
    [[nodiscard]] vec3 punctualRadiance(const SurfacePoint& point, const Gloss& gloss, Sampler& sampler,
                                        uint64_t& rays) const;
    [[nodiscard]] vec3 emitterRadiance(const SurfacePoint& point, const Gloss& gloss, Sampler& sampler,
                                       uint64_t& rays) const;

    RayTracer tracer_;
    std::vector<PunctualLight> lights_;
    Emitters emitters_;
    LightTree punctualTree_; ///< of the lights that bounce, when they are many; else empty
    std::vector<uint32_t> lightOfItem_;
    Sky sky_;
};

/// PathTracer::lightVisibility() for eight points at once.
class ShadowPacket {
public:
    explicit ShadowPacket(const PathTracer& paths) : paths_(paths) { RayTracer::clear(packet_); }

    void add(int lane, const PunctualLight& light, const SurfacePoint& point, vec2 disc, uint64_t& rays)
    {
        if (!paths_.shadowsFall(light, point)) return;
        const PathTracer::ShadowRay ray = paths_.shadowRay(light, point, disc, rays);
        embree::setRay(packet_, lane, ray.origin, ray.direction);
        packet_.tnear[lane] = ray.tMin;
        packet_.tfar[lane] = ray.tMax;
        valid_.lane[lane] = -1;
        any_ = true;
    }
    /// What of each lane's light arrives, 0…1; 1 where it throws no shadows.
    std::array<float, embree::kPacket> trace()
    {
        std::array<float, embree::kPacket> shares;
        shares.fill(1.0f);
        if (!any_) return shares;
        const std::array<float, embree::kPacket> transmittance = paths_.surfaces().transmittance(valid_, packet_);
        for (std::size_t lane = 0; lane < shares.size(); ++lane) {
            if (valid_.lane[lane] != 0) shares[lane] = transmittance[lane];
        }
        return shares;
    }

private:
    const PathTracer& paths_;
    RTCRay8 packet_;
    alignas(32) embree::LaneMask valid_{};
    bool any_ = false;
};

} // namespace halflight
