// Check probes against what renderers interpolate there.
#include "bake/probes/probe_placement.h"
#include "bake/probes/probes.h"

#include "halflight/render/probes.h"
#include "halflight/shading/color.h"
#include "halflight/shading/sh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>

namespace halflight {
namespace {

/// Standard deviation of the irradiance on a side, from the variance of a coefficient.
float noiseOfSide(float variance)
{
    float squares = 0.0f;
    for (int i = 0; i < 9; ++i) {
        const float weight = shading::shIrradianceWeight(i, vec3(0, 1, 0));
        squares += weight * weight;
    }
    return std::sqrt(variance * squares);
}

float errorOf(const ProbeInterpolator& probes, vec3 place, const ProbeEstimate& check, float dark)
{
    const std::array<float, 6> found = irradianceAround(probes.sample(place).radiance);
    const std::array<float, 6> right = irradianceAround(withoutRinging(check.radiance));
    float difference = 0.0f;
    float all = 0.0f;
    for (std::size_t i = 0; i < 6; ++i) {
        difference += std::abs(found[i] - right[i]) - noiseOfSide(check.variance);
        all += std::max(right[i], dark);
    }
    return all > 0.0f ? std::max(difference, 0.0f) / all : 0.0f;
}

Bounds boundsOf(const Scene& scene, const Object& object)
{
    Bounds bounds;
    for (const MeshPart& part : scene.meshes[std::size_t(object.mesh)].parts)
        for (const vec3 p : part.positions) bounds.extend(vec3(object.worldFromObject * vec4(p, 1.0f)));
    return bounds;
}

/// The static object whose bounds are nearest to a place, for messages.
std::string nearestObject(const Scene& scene, vec3 place)
{
    const Object* nearest = nullptr;
    float least = kInfinity;
    for (const Object& object : scene.objects) {
        if (!object.isStatic || object.mesh < 0) continue;
        const Bounds bounds = boundsOf(scene, object);
        const vec3 off = glm::max(glm::max(bounds.min - place, place - bounds.max), vec3(0.0f));
        if (bounds.empty() || glm::length(off) >= least) continue;
        least = glm::length(off);
        nearest = &object;
    }
    return nearest != nullptr ? nearest->name : std::string();
}

} // namespace

ProbeCheck checkProbes(const BakedScene& baked, const BakedProbes& probes, std::vector<std::string>& warnings)
{
    ProbeCheck result;
    const float dark = darkIrradiance(baked.probes.probes).value_or(0.0f);
    const ProbeInterpolator interpolator(baked);
    std::vector<std::pair<float, std::size_t>> off;
    for (std::size_t i = 0; i < probes.checks.size(); ++i) {
        if (!probes.checks[i].valid) continue;
        const float error = errorOf(interpolator, probes.checkedAt[i], probes.checks[i], dark);
        ++result.places;
        result.meanError += error;
        result.mostError = std::max(result.mostError, error);
        if (error > ProbeCheck::kOff) off.emplace_back(-error, i);
    }
    result.off = int(off.size());
    if (result.places > 0) result.meanError /= float(result.places);
    if (off.empty()) return result;
    std::sort(off.begin(), off.end());
    std::string places; // the worst three
    for (std::size_t k = 0; k < std::min<std::size_t>(3, off.size()); ++k) {
        const vec3 place = probes.checkedAt[off[k].second];
        const glm::dvec3 world = glm::dvec3(place) + baked.scene.originMeters;
        const std::string name = nearestObject(baked.scene, place);
        char text[160];
        std::snprintf(text, sizeof(text), "%s%.0f %% at (%.1f, %.1f, %.1f)", k > 0 ? ", " : "",
                      -100 * double(off[k].first), world.x, world.y, world.z);
        places += text;
        if (!name.empty()) places += " near '" + name + "'";
    }
    warnings.push_back("probes: light on moving objects is off by more than 25 % at " + std::to_string(off.size()) +
                       " of " + std::to_string(result.places) + " places checked: " + places +
                       "; --probe-spacing makes all probes denser, halflight_probes puts them where they matter");
    return result;
}

} // namespace halflight
