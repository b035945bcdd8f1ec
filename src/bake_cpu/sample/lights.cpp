#include "bake_cpu/sample/lights.h"

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
        shading::orthonormalBasis(-p.axis, p.tangent, p.bitangent);
        p.range = light.rangeMeters;
        p.spotConstants = shading::spotConstants(light.innerConeRadians, light.outerConeRadians);
        p.cosOuterCone = std::cos(light.outerConeRadians);
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
            const bool subtractive = mixed && light.baking.mixedMode == MixedLightingMode::Subtractive;
            p.maskOfLight = subtractive && light.baking.occlusionMaskChannel >= 0;
            p.directAtTexels = baked || (subtractive && !p.maskOfLight);
            p.directAtProbes = baked;
            p.bounces = baked || mixed;
            p.indirectMultiplier = light.indirectMultiplier;
            p.channel = light.baking.occlusionMaskChannel;
            if (light.type != LightType::Directional) p.reach = light.baking.reachMeters;
        }
        lights.push_back(p);
    }
    return lights;
}

LightRay sampleLightRay(const PunctualLight& light, vec3 origin, vec2 disc)
{
    if (light.type == shading::kLightDirectional) {
        if (light.tanAngularRadius <= 0.0f) return {-light.axis, 1.0e30f};
        const vec3 offset = light.tanAngularRadius * (disc.x * light.tangent + disc.y * light.bitangent);
        return {glm::normalize(offset - light.axis), 1.0e30f};
    }
    vec3 toLight = light.position - origin;
    if (light.radius > 0.0f) {
        const float length = glm::length(toLight);
        if (length > 0.0f) {
            vec3 tangent;
            vec3 bitangent;
            shading::orthonormalBasis(toLight / length, tangent, bitangent);
            toLight += light.radius * (disc.x * tangent + disc.y * bitangent);
        }
    }
    const float distance = std::max(glm::length(toLight), 1.0e-20f);
    return {toLight / distance, distance};
}

Emitters::Emitters(const RayTracer& tracer) : tracer_(tracer)
{
    const BakeGeometry& geometry = tracer.geometry();
    std::vector<LightItem> items;
    for (uint32_t t = 0; t < geometry.triangles.size(); ++t) {
        const TransportMaterial& material = tracer.materialOfTriangle(t);
        if (material.emission == vec3(0.0f)) continue;
        const uvec3 v = geometry.triangles[t];
        Emissive e;
        e.triangle = t;
        e.origin = geometry.positions[v.x];
        e.edge1 = geometry.positions[v.y] - e.origin;
        e.edge2 = geometry.positions[v.z] - e.origin;
        e.normal = geometry.geometricNormal(t);
        const float area = 0.5f * glm::length(glm::cross(e.edge1, e.edge2));
        if (!(area > 0.0f)) continue;
        e.inverseArea = 1.0f / area;
        e.uniform = !material.emissive && material.alphaMode == Material::AlphaMode::Opaque;
        e.radiance = material.emission;
        e.doubleSided = material.doubleSided;
        e.rayVisible = geometry.parts[geometry.partOfTriangle[t]].castShadows;
        // Mean emission over a few points; textured triangles keep a small share whatever the points say.
        float mean = luminance(material.emission);
        if (material.emissive) {
            constexpr int kPoints = 16;
            const float full = mean;
            mean = 0.0f;
            for (int i = 0; i < kPoints; ++i) {
                const vec2 u = r2Point(i);
                mean += luminance(tracer.emissionAt(t, shading::sampleTriangle(u))) / float(kPoints);
            }
            mean = std::max(mean, 0.01f * full);
        }
        if (!(mean > 0.0f)) continue;
        LightItem item;
        item.bounds.extend(e.origin);
        item.bounds.extend(e.origin + e.edge1);
        item.bounds.extend(e.origin + e.edge2);
        item.axis = e.normal;
        item.twoSided = e.doubleSided;
        item.power = area * mean * (e.doubleSided ? 2.0f : 1.0f);
        items.push_back(item);
        triangles_.push_back(e);
    }
    if (triangles_.empty()) return;
    itemOfTriangle_.assign(geometry.triangles.size(), ~0u);
    for (std::size_t i = 0; i < triangles_.size(); ++i) itemOfTriangle_[triangles_[i].triangle] = uint32_t(i);
    tree_ = LightTree(items);
}

inline EmitterSample Emitters::at(const LightTree::Choice& choice, float v) const
{
    const Emissive& e = triangles_[choice.item];
    const vec2 barycentric = shading::sampleTriangle(vec2(choice.u, v));
    EmitterSample s;
    s.position = e.origin + barycentric.x * e.edge1 + barycentric.y * e.edge2;
    s.normal = e.normal;
    s.radiance = e.radiance;
    // Holes do not shine, and what is half transparent shines by half.
    if (!e.uniform) {
        s.radiance = tracer_.emissionAt(e.triangle, barycentric) * tracer_.coverageAt(e.triangle, barycentric);
    }
    s.rayVisible = e.rayVisible;
    s.doubleSided = e.doubleSided;
    s.pdfArea = choice.probability * e.inverseArea;
    return s;
}

EmitterSample Emitters::sample(vec3 position, vec3 normal, vec2 u) const
{
    const LightTree::Choice choice = tree_.sample(position, normal, u.x);
    return choice.probability > 0.0f ? at(choice, u.y) : EmitterSample{};
}

void Emitters::sample(const LightTree::Cut& cut, const LightTree::Points& positions, const LightTree::Points& normals,
                      const LightTree::Cut::Lanes<bool>& wanted, const Vec2Lanes<LightTree::Cut::kLanes>& u,
                      EmitterLanes& samples) const
{
    LightTree::Cut::Lanes<LightTree::Choice> choices;
    tree_.sample(cut, positions, normals, wanted, u.x, choices);
    for (std::size_t lane = 0; lane < EmitterLanes::kLanes; ++lane) {
        samples.pdfArea[lane] = 0.0f;
        if (choices[lane].probability > 0.0f) samples.set(lane, at(choices[lane], u.y[lane]));
    }
}

float Emitters::pdfArea(const Receiver& receiver, uint32_t triangle) const
{
    if (itemOfTriangle_.empty() || itemOfTriangle_[triangle] == ~0u) return 0.0f;
    const uint32_t item = itemOfTriangle_[triangle];
    const float probability = receiver.cut != nullptr ? tree_.probability(*receiver.cut, receiver.lane, item,
                                                                          receiver.position, receiver.normal)
                                                      : tree_.probability(item, receiver.position, receiver.normal);
    return probability * triangles_[item].inverseArea;
}

LightTree punctualTree(const std::vector<PunctualLight>& lights, std::vector<uint32_t>& itemLights)
{
    std::vector<LightItem> items;
    itemLights.clear();
    for (std::size_t i = 0; i < lights.size(); ++i) {
        const PunctualLight& light = lights[i];
        const float power = luminance(light.colorIntensity) * light.indirectMultiplier;
        if (!light.bounces || light.type == shading::kLightDirectional || !(power > 0.0f)) continue;
        LightItem item;
        item.bounds.extend(light.position);
        item.axis = light.axis;
        item.cosSpread = light.type == shading::kLightSpot ? light.cosOuterCone : -1.0f;
        item.power = power;
        item.range = light.range;
        items.push_back(item);
        itemLights.push_back(uint32_t(i));
    }
    return LightTree(items);
}

} // namespace halflight
