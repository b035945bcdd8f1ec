#pragma once
// The path tracer: one estimator of incoming radiance, used by lightmap, probes and reference pictures.

#include "bake_cpu/lights.h"
#include "bake_cpu/sampler.h"
#include "bake_cpu/surface.h"

#include "halflight/scene/scene.h"

#include <cstdint>
#include <vector>

namespace halflight {

class PathTracer {
public:
    /// `scene` and `geometry` outlive the tracer.
    PathTracer(const Scene& scene, const BakeGeometry& geometry, LightUse use);

    [[nodiscard]] bool ok() const { return tracer_.ok(); }
    [[nodiscard]] const SurfaceTracer& surfaces() const { return tracer_; }
    [[nodiscard]] const std::vector<PunctualLight>& lights() const { return lights_; }

    /// Radiance that arrives at `origin` from `direction` after at most `bounces` reflections.
    struct Incoming {
        vec3 radiance{0.0f};
        bool firstHitBackFace = false;
    };
    /// directionPdf: density per steradian with which `direction` was chosen when emitters were sampled at `origin` too
    /// (their hits are then weighted), 0 when they were not.
    Incoming incoming(vec3 origin, vec3 direction, float directionPdf, int bounces, Sampler& sampler,
                      uint64_t& rays) const;

    /// Radiance that leaves a surface seen from a camera: linear, diffuse surfaces.
    vec3 seenFromCamera(vec3 origin, vec3 direction, float tMax, int bounces, Sampler& sampler, uint64_t& rays) const;

    /// Irradiance from emissive triangles, one sample, weighted against cosine-distributed directions; the direction
    /// is that of the emitter's point.
    struct EmitterAtSurface {
        vec3 direction{0.0f};
        vec3 irradiance{0.0f};
    };
    EmitterAtSurface emitterIrradiance(const SurfacePoint& point, Sampler& sampler, uint64_t& rays) const;
    /// A sampled emitter seen from a point in space: radiance over pdf (per steradian), with its direction.
    struct EmitterInSpace {
        vec3 direction{0.0f};
        vec3 radianceOverPdf{0.0f};
    };
    EmitterInSpace emitterInSpace(vec3 position, float directionPdf, Sampler& sampler, uint64_t& rays) const;

    /// Share of the light's disc seen from a surface point along one sampled ray: 0 or 1 (1 for lights without
    /// shadows).
    float lightVisibility(const PunctualLight& light, const SurfacePoint& point, vec2 u, uint64_t& rays) const;
    float lightVisibilityInSpace(const PunctualLight& light, vec3 position, vec2 u, uint64_t& rays) const;

    /// A gather direction around the point's normal, cosine-distributed, never below the surface.
    static vec3 gatherDirection(const SurfacePoint& point, vec2 u);
    [[nodiscard]] vec3 rayOrigin(const SurfacePoint& point) const;

private:
    vec3 follow(SurfaceHit hit, vec3 direction, float directionPdf, int bounces, bool directFromCamera,
                Sampler& sampler, uint64_t& rays) const;
    vec3 punctualIrradiance(const SurfacePoint& point, bool direct, Sampler& sampler, uint64_t& rays) const;
    float emitterPdf(const SurfaceHit& hit, vec3 direction) const;

    SurfaceTracer tracer_;
    std::vector<PunctualLight> lights_;
    Emitters emitters_;
    Sky sky_;
};

} // namespace halflight
