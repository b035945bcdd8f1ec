#pragma once
// A room that both integrators bake, and the difference of their results.

#include "bake/test_scene.h"

#include <cmath>
#include <utility>
#include <vector>

namespace halflight::test {

/// A room with a block, a lamp under the ceiling, a sun through a missing wall, and a sky.
inline Scene room(bool lamp, bool sun, bool sky)
{
    constexpr int kPage = 64;
    Scene scene;
    const int white = addMaterial(scene, vec3(0.7f));
    const int red = addMaterial(scene, vec3(0.6f, 0.1f, 0.1f));
    addRectangle(scene, {vec3(-1, 0, 1), vec3(2, 0, 0), vec3(0, 0, -2)}, white, kPage, {vec2(1), vec2(21)});
    addRectangle(scene, {vec3(-1, 2, -1), vec3(2, 0, 0), vec3(0, 0, 2)}, white, kPage, {vec2(24, 1), vec2(44, 21)});
    addRectangle(scene, {vec3(-1, 0, -1), vec3(2, 0, 0), vec3(0, 2, 0)}, white, kPage, {vec2(1, 24), vec2(21, 44)});
    addRectangle(scene, {vec3(-1, 0, 1), vec3(0, 0, -2), vec3(0, 2, 0)}, red, kPage, {vec2(24, 24), vec2(44, 44)});
    addBox(scene, vec3(-0.2f, 0.0f, -0.4f), vec3(0.4f, 0.9f, 0.1f), white, false);
    // The box's faces have texels of their own but for one, where paths find no cache.
    for (int i = 0; i < 5; ++i) {
        Object& face = scene.objects[scene.objects.size() - 6 + std::size_t(i)];
        MeshPart& part = scene.meshes[std::size_t(face.mesh)].parts[0];
        const vec2 a(46.0f / kPage, (1.0f + 12.0f * float(i)) / kPage);
        const vec2 b = a + 10.0f / kPage;
        part.lightmapUv = {a, {b.x, a.y}, b, {a.x, b.y}};
        face.lightmap.page = 0;
    }
    if (lamp) {
        const int glow = addMaterial(scene, vec3(0.0f), vec3(12.0f));
        addRectangle(scene, {vec3(-0.3f, 1.95f, -0.3f), vec3(0.6f, 0, 0), vec3(0, 0, 0.6f)}, glow, kPage);
    }
    if (sun) {
        scene.lights.push_back(
            makeLight(LightType::Directional, vec3(0), vec3(-0.6f, -0.8f, -0.5f), 8.0f, LightMode::Mixed));
        scene.lights.push_back(
            makeLight(LightType::Point, vec3(0.6f, 1.2f, 0.5f), vec3(0, -1, 0), 1.0f, LightMode::Baked));
        scene.lights.back().radiusMeters = 0.1f;
    }
    if (sky) scene.sky = {vec3(1.0f), vec3(0.6f), vec3(0.2f)};
    return scene;
}

inline std::vector<IrradianceEstimate> bakeWith(Scene scene, IntegratorKind kind, int samples, int bounces,
                                                float noise = 0.0f)
{
    IntegrationSettings settings;
    settings.integrator = kind;
    settings.samples = samples;
    settings.shadowSamples = 64;
    settings.bounces = bounces;
    settings.cache.noiseTarget = noise;
    settings.seed = kind == IntegratorKind::Path ? 7 : 1;
    constexpr int kPage = 64;
    Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, settings);
    return bench.irradiance();
}

struct Difference {
    double bias = 0.0; ///< of the mean
    double rmse = 0.0; ///< over the mean
    double momentBias = 0.0;
};

inline Difference difference(const std::vector<IrradianceEstimate>& a, const std::vector<IrradianceEstimate>& reference)
{
    Difference d;
    double mean = 0.0;
    double moment = 0.0;
    for (std::size_t i = 0; i < reference.size(); ++i) {
        if (!reference[i].valid || !a[i].valid) continue;
        const double l = double(luminance(a[i].irradiance)) - double(luminance(reference[i].irradiance));
        d.bias += l;
        d.rmse += l * l;
        mean += double(luminance(reference[i].irradiance));
        d.momentBias += double(glm::length(a[i].moment)) - double(glm::length(reference[i].moment));
        moment += double(glm::length(reference[i].moment));
    }
    const auto n = double(reference.size());
    return {d.bias / mean, std::sqrt(d.rmse / n) / (mean / n), d.momentBias / moment};
}

} // namespace halflight::test
