#include "bake_cpu/lights.h"

#include "halflight/shading/sampling.h"

#include <algorithm>
#include <cmath>

namespace halflight {

std::vector<PunctualLight> punctualLights(const Scene& scene, LightUse use)
{
    std::vector<PunctualLight> lights;
    for (const Light& light : scene.lights) {
        PunctualLight p;
        p.type = light.type == LightType::Directional ? shading::kLightDirectional
                 : light.type == LightType::Spot      ? shading::kLightSpot
                                                      : shading::kLightPoint;
        p.colorIntensity = light.color * light.intensity;
        p.position = light.position();
        p.axis = light.direction();
        p.range = light.rangeMeters;
        p.spotConstants = shading::spotConstants(light.innerConeRadians, light.outerConeRadians);
        p.radius = light.type == LightType::Directional ? 0.0f : light.radiusMeters;
        p.tanAngularRadius = light.type == LightType::Directional ? std::tan(light.angularRadiusRadians) : 0.0f;
        p.castShadows = light.castShadows;
        p.shadowStrength = light.shadowStrength;
        if (use == LightUse::Reference) {
            p.directAtTexels = p.directAtProbes = p.bounces = true;
        } else {
            // Spec S6. Subtractive lightmaps hold the direct light of mixed lights too; dynamic objects get it at run
            // time, so the probes never do.
            const bool mixed = light.baking.bakeType == LightMode::Mixed;
            const bool baked = light.baking.bakeType == LightMode::Baked;
            p.directAtTexels = baked || (mixed && light.baking.mixedMode == MixedLightingMode::Subtractive);
            p.directAtProbes = baked;
            p.bounces = baked || mixed;
            p.indirectMultiplier = light.indirectMultiplier;
            p.channel = light.baking.occlusionMaskChannel;
        }
        lights.push_back(p);
    }
    return lights;
}

LightRay sampleLightRay(const PunctualLight& light, vec3 origin, vec2 u)
{
    vec3 tangent;
    vec3 bitangent;
    if (light.type == shading::kLightDirectional) {
        if (light.tanAngularRadius <= 0.0f) return {-light.axis, 1.0e30f};
        shading::orthonormalBasis(-light.axis, tangent, bitangent);
        const vec2 disc = shading::sampleDisc(u) * light.tanAngularRadius;
        return {glm::normalize(-light.axis + disc.x * tangent + disc.y * bitangent), 1.0e30f};
    }
    vec3 toLight = light.position - origin;
    if (light.radius > 0.0f) {
        const float length = glm::length(toLight);
        if (length > 0.0f) {
            shading::orthonormalBasis(toLight / length, tangent, bitangent);
            const vec2 disc = shading::sampleDisc(u) * light.radius;
            toLight += disc.x * tangent + disc.y * bitangent;
        }
    }
    const float distance = std::max(glm::length(toLight), 1.0e-20f);
    return {toLight / distance, distance};
}

Emitters::Emitters(const SurfaceTracer& tracer) : tracer_(tracer)
{
    const BakeGeometry& geometry = tracer.geometry();
    std::vector<double> power;
    double total = 0.0;
    for (uint32_t t = 0; t < geometry.triangles.size(); ++t) {
        const TransportMaterial& material = tracer.materialOfTriangle(t);
        if (material.emission == vec3(0.0f)) continue;
        const uvec3 v = geometry.triangles[t];
        const float area = 0.5f * glm::length(glm::cross(geometry.positions[v.y] - geometry.positions[v.x],
                                                         geometry.positions[v.z] - geometry.positions[v.x]));
        if (!(area > 0.0f)) continue;
        // Mean emission over a few points; textured triangles keep a small share whatever the points say.
        float mean = luminance(material.emission);
        if (material.emissive) {
            constexpr int kPoints = 16;
            const float full = mean;
            mean = 0.0f;
            for (int i = 0; i < kPoints; ++i) {
                const vec2 u = glm::fract(vec2(0.5f) + float(i) * vec2(0.7548776662f, 0.5698402910f));
                mean += luminance(tracer.emissionAt(t, shading::sampleTriangle(u))) / float(kPoints);
            }
            mean = std::max(mean, 0.01f * full);
        }
        if (!(mean > 0.0f)) continue;
        triangles_.push_back(t);
        power.push_back(double(area) * double(mean));
        total += power.back();
    }
    if (triangles_.empty()) return;
    pdfOfTriangle_.assign(geometry.triangles.size(), 0.0f);
    double sum = 0.0;
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
        sum += power[i];
        cumulative_.push_back(float(sum / total));
        const uvec3 v = geometry.triangles[triangles_[i]];
        const float area = 0.5f * glm::length(glm::cross(geometry.positions[v.y] - geometry.positions[v.x],
                                                         geometry.positions[v.z] - geometry.positions[v.x]));
        const float probability = cumulative_[i] - (i > 0 ? cumulative_[i - 1] : 0.0f);
        pdfOfTriangle_[triangles_[i]] = probability / area;
    }
    cumulative_.back() = 1.0f;
}

EmitterSample Emitters::sample(vec2 uTriangle, vec2 uPoint) const
{
    const auto found = std::upper_bound(cumulative_.begin(), cumulative_.end(), uTriangle.x);
    const auto index = std::min(std::size_t(found - cumulative_.begin()), triangles_.size() - 1);
    const uint32_t triangle = triangles_[index];
    const vec2 barycentric = shading::sampleTriangle(uPoint);
    const BakeGeometry& geometry = tracer_.geometry();
    const uvec3 v = geometry.triangles[triangle];
    EmitterSample s;
    s.position = (1.0f - barycentric.x - barycentric.y) * geometry.positions[v.x] +
                 barycentric.x * geometry.positions[v.y] + barycentric.y * geometry.positions[v.z];
    s.normal = geometry.geometricNormal(triangle);
    // Holes do not shine, and what is half transparent shines by half.
    s.radiance = tracer_.emissionAt(triangle, barycentric) * tracer_.coverageAt(triangle, barycentric);
    s.rayVisible = geometry.parts[geometry.partOfTriangle[triangle]].castShadows;
    s.doubleSided = tracer_.materialOfTriangle(triangle).doubleSided;
    s.pdfArea = pdfOfTriangle_[triangle];
    return s;
}

} // namespace halflight
