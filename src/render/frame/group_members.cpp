// What the weights of light groups make of their members: lights, emission, sky.
#include "halflight/render/compose.h"
#include "halflight/scene/light_groups.h"
#include "halflight/scene/turning_lights.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace halflight {
namespace {

/// Of sums and products of floats that went through a file.
constexpr float kWeightTolerance = 1.0e-4f;

bool isNear(vec3 a, vec3 b, float tolerance)
{
    const vec3 most = glm::max(glm::abs(a), glm::abs(b));
    return glm::all(glm::lessThanEqual(glm::abs(a - b), vec3(tolerance * std::max({most.x, most.y, most.z}))));
}

/// The light of a lamp as a colour of at most 1 and an intensity, which stays where it can. A lamp that is off is
/// black, and keeps its intensity for the next bake.
void setColorIntensity(Light& light, vec3 colorIntensity)
{
    const float most = std::max({colorIntensity.x, colorIntensity.y, colorIntensity.z});
    if (!(light.intensity >= most)) light.intensity = most;
    light.color = most > 0.0f ? colorIntensity / light.intensity : vec3(0.0f);
}

/// Of a gradient that changes: zenith, horizon or ground.
bool isSkyPart(const BakedGroup& group)
{
    Sky sky;
    return skyPartOf(sky, group.name) != nullptr;
}

/// Weights of the groups of a light that turns.
template<typename Vector> std::span<Vector> ownWeights(const Light& light, std::span<Vector> weights)
{
    const TurningLight& turning = light.baking.turning;
    return weights.subspan(std::size_t(turning.group), turning.directions.size());
}

} // namespace

void followTurningLights(std::span<const Light> lights, std::span<vec3> weights)
{
    for (const Light& light : lights) {
        if (!turns(light)) continue;
        vec3 all(0.0f);
        for (int c = 0; c < 3; ++c)
            if (light.baking.white[c] > 0.0f) all[c] = light.color[c] * light.intensity / light.baking.white[c];
        setTurning(light, all, weights);
    }
}

void setTurning(const Light& light, vec3 weight, std::span<vec3> weights)
{
    const std::vector<float> shares = weightsOfDirections(light.baking.turning.directions, light.direction());
    const std::span<vec3> own = ownWeights(light, weights);
    float most = 0.0f;
    float change = 0.0f;
    for (std::size_t d = 0; d < own.size(); ++d)
        for (int c = 0; c < 3; ++c) {
            most = std::max({most, own[d][c], weight[c] * shares[d]});
            change = std::max(change, std::abs(own[d][c] - weight[c] * shares[d]));
        }
    if (change <= kWeightTolerance * most) return; // those of a file went through it
    for (std::size_t d = 0; d < own.size(); ++d) own[d] = weight * shares[d];
}

vec3 weightOfTurning(const Light& light, std::span<const vec3> weights)
{
    const std::vector<float> shares = weightsOfDirections(light.baking.turning.directions, light.direction());
    vec3 sum(0.0f);
    for (const vec3 weight : ownWeights(light, weights)) sum += weight;
    return sum / std::accumulate(shares.begin(), shares.end(), 0.0f);
}

void composeMembers(const Scene& saved, std::span<const BakedGroup> groups, std::span<const vec3> weights, Scene& scene)
{
    for (std::size_t i = 0; i < scene.lights.size(); ++i) {
        Light& light = scene.lights[i];
        if (turns(light) && !groups.empty()) {
            const vec3 target = light.baking.white * weightOfTurning(light, weights);
            if (!isNear(light.color * light.intensity, target, kWeightTolerance)) setColorIntensity(light, target);
            light.baking.atBake.colorIntensity = light.color * light.intensity;
        }
        if (light.baking.group < 0) continue;
        const auto group = std::size_t(light.baking.group);
        const vec3 target = light.baking.white * weights[group];
        if (weights[group] == groups[group].weight) {
            light.color = saved.lights[i].color;
            light.intensity = saved.lights[i].intensity;
            light.baking.atBake = saved.lights[i].baking.atBake;
            continue;
        }
        if (!isNear(light.color * light.intensity, target, kWeightTolerance)) setColorIntensity(light, target);
        light.baking.atBake.colorIntensity = light.color * light.intensity;
    }
    for (std::size_t i = 0; i < scene.materials.size(); ++i) {
        Material& material = scene.materials[i];
        if (material.bakedGroup < 0) continue;
        const auto group = std::size_t(material.bakedGroup);
        material.emissiveNits = weights[group] == groups[group].weight ? saved.materials[i].emissiveNits
                                                                       : material.whiteNits * weights[group];
    }
}

vec3 composedSkyFactor(std::span<const BakedGroup> groups, std::span<const vec3> weights)
{
    for (std::size_t g = 0; g < groups.size(); ++g)
        if (groups[g].sky && !isSkyPart(groups[g]) && weights[g] != groups[g].weight)
            return skyFactor(groups[g].weight, weights[g]);
    return vec3(1.0f);
}

Sky composedSky(const Sky& saved, std::span<const BakedGroup> groups, std::span<const vec3> weights)
{
    Sky sky = saved;
    for (std::size_t g = 0; g < groups.size(); ++g) {
        if (!groups[g].sky) continue;
        vec3* const part = skyPartOf(sky, groups[g].name);
        if (part == nullptr) return skyAtWeight(saved, groups[g].weight, weights[g]);
        if (weights[g] != groups[g].weight) *part = weights[g]; // cd/m2
    }
    return sky;
}

std::optional<vec3> weightOfLights(const Scene& scene, int group, vec3 weight)
{
    const auto isMember = [&](const Light& light) { return light.baking.group == group; };
    if (std::ranges::none_of(scene.lights, isMember)) return std::nullopt;
    vec3 found = weight;
    for (int c = 0; c < 3; ++c) {
        const Light* brightest = nullptr;
        for (const Light& light : scene.lights)
            if (isMember(light) && light.baking.white[c] > (brightest ? brightest->baking.white[c] : 0.0f))
                brightest = &light;
        if (brightest) found[c] = brightest->color[c] * brightest->intensity / brightest->baking.white[c];
    }
    for (const Light& light : scene.lights)
        if (isMember(light) && !isNear(light.color * light.intensity, light.baking.white * found, kWeightTolerance))
            return std::nullopt;
    return isNear(found, weight, kWeightTolerance) ? weight : found;
}

} // namespace halflight
