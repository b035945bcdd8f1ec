#pragma once
// The path tracer: one estimator of incoming radiance for lightmaps and probes.

#include "transport/sample/direct_light.h"
#include "transport/sample/gather_direction.h"
#include "transport/sample/path_light.h"

#include <array>
#include <cstdint>
#include <span>
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
    /// Radiance of each component of a hit that was found.
    void (*findComponents)(const void* cache, const RayEnd& end, int reflections, std::span<vec3> out) = nullptr;
};

class PathTracer {
public:
    /// `scene` and `geometry` outlive the tracer.
    PathTracer(const Scene& scene, const BakeGeometry& geometry, LightUse use, Bounces bounces,
               const MakeKernels& makeKernels, const LightComponents& components = {})
        : tracer_(scene, geometry, makeKernels), light_(scene, tracer_, use, components), direct_(tracer_, light_),
          bounces_(bounces)
    {}
    PathTracer(const PathTracer&) = delete;
    PathTracer& operator=(const PathTracer&) = delete;

    [[nodiscard]] bool ok() const { return tracer_.ok(); }
    [[nodiscard]] const RayTracer& surfaces() const { return tracer_; }
    [[nodiscard]] const SceneLight& light() const { return light_; }
    [[nodiscard]] const DirectLight& direct() const { return direct_; }

    [[nodiscard]] bool glossy() const { return bounces_ == Bounces::Glossy; }
    /// Albedo of the diffuse part of a surface.
    [[nodiscard]] vec3 albedoOf(const SurfaceReflectance& surface) const
    {
        return glossy() ? surface.diffuseAlbedo() : surface.transportAlbedo();
    }

    /// Radiance that arrives at `origin` from `direction` after at most `bounces` reflections, without the sky's bright
    /// part where the ray itself leaves the scene.
    struct Incoming {
        vec3 radiance{0.0f};
        bool firstHitBackFace = false;
    };
    /// The ray starts at the receiver's position. `directionPdf`: density of `direction` per steradian, if `receiver`
    /// samples emitters too (the MIS weight of emitter hits), else 0. `lights` as of pathRadiance().
    Incoming incoming(const Receiver& receiver, vec3 direction, float directionPdf, int bounces, Sampler& sampler,
                      uint64_t& rays, PathLights* lights = nullptr) const;

    /// Radiance that a hit sends back along `direction`, through the glass before it, after at most `bounces`
    /// reflections. The path ends where `lookup` has the radiance. `byBounce`, if given, receives the parts of 0, 1, …
    /// reflections. `lights`, if given, receives the parts of the components.
    vec3 pathRadiance(RayHit at, vec3 direction, Receiver from, float directionPdf, int bounces, Sampler& sampler,
                      uint64_t& rays, const RadianceLookup& lookup = {}, std::vector<vec3>* byBounce = nullptr,
                      PathLights* lights = nullptr) const;

    /// Radiance of a sampled punctual light, of an emitter and of the sky.
    using SampledLights = std::array<DirectLight::Reflected, 3>;
    /// What a specular lobe sends back along the ray that has hit it.
    struct Reflection {
        vec3 lights{0.0f}; ///< radiance of sampled lights
        vec3 throughput{0.0f};
        vec3 direction{0.0f}; ///< of the ray that goes on
        float pdf = 0.0f;     ///< of the direction, per steradian
        Receiver from;
        RayHit next; ///< where `throughput` is not zero; its tint is not in `throughput`
    };
    /// One sample of the lobe of a hit, over `probability`, that with which the lobe is sampled. Light that arrives is
    /// throughput times the radiance along the next ray, where emission of surfaces has the weight of
    /// weightedEmission(). The ray goes on by Russian roulette.
    /// `ofLights`, if given, receives the parts of the sampled lights.
    Reflection reflect(const SurfaceHit& hit, const SpecularLobe& lobe, float probability, Sampler& sampler,
                       uint64_t& rays, SampledLights* ofLights = nullptr) const;

private:
    /// Radiance of sampled lights that the diffuse part of a surface reflects. `ofLights` as of reflect().
    vec3 reflectDiffusely(const SurfacePoint& point, vec3 albedo, Sampler& sampler, uint64_t& rays,
                          SampledLights* ofLights) const;
    /// Notes the components of what `lookup` has found. `before`: reflections up to the path's start.
    void noteCached(const RadianceLookup& lookup, const RayEnd& end, int reflections, vec3 throughput, int before,
                    PathLights& lights) const;

    RayTracer tracer_;
    SceneLight light_;
    DirectLight direct_;
    Bounces bounces_;
};

} // namespace halflight
