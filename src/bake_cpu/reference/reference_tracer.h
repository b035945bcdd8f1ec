#pragma once
// The path tracer of reference pictures: glTF's BRDF at every surface.

#include "bake_cpu/reference/detailed_materials.h"
#include "bake_cpu/reference/scattering.h"
#include "transport/sample/path_tracer.h"

#include "halflight/bake_cpu/embree_integrator.h"

namespace halflight {

/// How light of emissive surfaces, of area lights and of a sky's bright places is sampled. Both (multiple importance
/// sampling) is what pictures use; each alone is an independent estimator of the same light.
enum class EmitterSampling { Both, Directions, Surfaces };

/// Unidirectional path tracing (Kajiya 1986) with next-event estimation and multiple importance sampling (Veach and
/// Guibas 1995). Unbiased for surfaces that reflect by shading::reflectLight() to the outside of their triangles.
/// Immutable after construction; all queries are thread-safe.
class ReferenceTracer {
public:
    struct Options {
        ReferenceSurfaces surfaces = ReferenceSurfaces::Full;
        float clampNits = 0.0f; ///< limit of light by way of two and more surfaces, per path and surface; 0 = none
        EmitterSampling emitters = EmitterSampling::Both;
    };
    /// `scene` and `paths` outlive the tracer. `paths` has the rays, the lights (each is used fully) and the emitters.
    ReferenceTracer(const Scene& scene, const PathTracer& paths, const Options& options);

    /// Radiance that arrives at `origin` from a unit direction by paths of at most `bounces` reflections between the
    /// last light source and the first surface. `use`: of the first ray.
    [[nodiscard]] vec3 radiance(vec3 origin, vec3 direction, RayUse use, int bounces, Sampler& sampler,
                                uint64_t& rays) const;

private:
    struct Hit {
        SurfacePoint point; ///< with the mapped normal
        vec3 emission{0.0f};
        Scattering scattering;
    };
    [[nodiscard]] Hit surfaceAt(const RayHit& at, vec3 view, bool first) const;
    [[nodiscard]] vec3 punctualLight(const Hit& hit, Sampler& sampler, uint64_t& rays) const;
    [[nodiscard]] vec3 areaContribution(const PunctualLight& light, const Hit& hit, vec2 disc) const;
    vec3 areaLightsAlong(const Hit& hit, vec3 direction, float directionPdf, const RayHit& next, uint64_t& rays) const;
    vec3 visibleUpTo(const Hit& hit, vec3 direction, float distance, const RayHit& next, uint64_t& rays) const;
    [[nodiscard]] vec3 emitterLight(const Hit& hit, Sampler& sampler, uint64_t& rays) const;
    [[nodiscard]] vec3 skyLight(const Hit& hit, Sampler& sampler, uint64_t& rays) const;
    [[nodiscard]] vec3 skyAlong(vec3 direction, float directionPdf) const;
    [[nodiscard]] float emissionWeight(const Hit& hit, vec3 direction, float distance, const Receiver& from,
                                       float directionPdf) const;
    [[nodiscard]] vec3 limited(vec3 light) const;

    const PathTracer& paths_;
    DetailedMaterials materials_;
    Options options_;
};

} // namespace halflight
