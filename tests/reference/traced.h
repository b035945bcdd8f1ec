#pragma once
// A scene with its reference tracer, and single points of its picture.

#include "bake/geometry/flatten.h"
#include "bake/seeds.h"
#include "bake/test_scene.h"
#include "bake_cpu/reference/reference_tracer.h"
#include "bake_cpu/trace/embree_kernels.h"

#include <memory>

namespace halflight::test {

struct Traced {
    Scene scene;
    BakeGeometry geometry;
    std::unique_ptr<PathTracer> paths;
    std::unique_ptr<ReferenceTracer> tracer;

    explicit Traced(Scene s, const ReferenceTracer::Options& options = {}) : scene(std::move(s))
    {
        geometry = flattenGeometry(scene, 1, GeometryFilter::All);
        paths = std::make_unique<PathTracer>(scene, geometry, LightUse::Reference, Bounces::Diffuse, embreeKernels());
        tracer = std::make_unique<ReferenceTracer>(scene, *paths, options);
    }
    /// Mean radiance from `direction` over `samples` paths.
    vec3 radiance(vec3 origin, vec3 direction, int samples, int bounces = 0, uint32_t seed = 7) const
    {
        glm::dvec3 sum(0.0);
        uint64_t rays = 0;
        for (int i = 0; i < samples; ++i) {
            Sampler sampler(seed, 11, uint32_t(i));
            sum +=
                glm::dvec3(tracer->radiance(origin, glm::normalize(direction), RayUse::Camera, bounces, sampler, rays));
        }
        return vec3(sum / double(samples));
    }
    /// The radiance of the origin, seen from a metre away in direction `view`.
    vec3 atOrigin(vec3 view, int samples, int bounces = 0, uint32_t seed = 7) const
    {
        return radiance(glm::normalize(view), -view, samples, bounces, seed);
    }
    /// Its green, with `samples` paths for each seed.
    SeedMean bySeeds(vec3 view, int samples, int bounces = 0) const
    {
        return overSeeds([&](uint32_t seed) { return atOrigin(view, samples, bounces, seed).y; });
    }
};

struct Finish {
    vec3 color{0.8f};
    float metallic = 0.0f;
    float roughness = 0.5f;
    float specular = 1.0f;
};

inline int addFinish(Scene& scene, const Finish& f)
{
    const int material = addMaterial(scene, f.color);
    scene.materials.back().metallic = f.metallic;
    scene.materials.back().roughness = f.roughness;
    scene.materials.back().specular = f.specular;
    return material;
}

/// A floor at y = 0 from -half to half, texture coordinates (0, 0) at (-half, 0, half) and (1, 1) at (half, 0, -half).
inline Object& addFloor(Scene& scene, int material, float half = 2.0f)
{
    addRectangle(scene, {vec3(-half, 0, half), vec3(2 * half, 0, 0), vec3(0, 0, -2 * half)}, material, 1);
    return scene.objects.back();
}

inline vec3 reflectedBy(const Finish& f, vec3 normal, vec3 view, vec3 direction, vec3 illuminance)
{
    return shading::reflectLight(f.color, f.metallic, f.roughness, f.specular, normal, glm::normalize(view), direction,
                                 illuminance);
}

} // namespace halflight::test
