#include "halflight/render/compose.h"

#include "halflight/base/parallel.h"
#include "halflight/base/rgb9e5.h"
#include "halflight/scene/turning_lights.h"
#include "halflight/shading/directional.h"

#include <algorithm>

namespace halflight {
namespace {

/// What the bake holds of one page by itself.
struct PageLight {
    const Image<uint32_t>* texels = nullptr;
    const ImageRgba8* directions = nullptr; ///< may be null
    float unitLux = 1.0f;
    vec3 weight{1.0f};
};

/// Light of a page, and its first moment where there are directions.
void addPage(const PageLight& page, ImageRgb32f& light, ImageRgb32f& moments)
{
    parallelFor(light.texelCount(), 65536, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const vec3 own = unpackRgb9e5(page.texels->data()[i]) * page.unitLux * page.weight;
            light.data()[i] += own;
            if (moments.empty() || page.directions == nullptr) continue;
            const vec3 encoded = vec3(page.directions->data()[i]) / 255.0f;
            moments.data()[i] += shading::directionMoment(own, encoded);
        }
    });
}

/// Keeps the alpha of `directions`, which says how far texels trust reflection probes.
void encodeDirectionsOf(const ImageRgb32f& light, const ImageRgb32f& moments, ImageRgba8& directions)
{
    for (std::size_t i = 0; i < light.texelCount(); ++i) {
        const vec3 encoded = shading::encodeMomentDirection(light.data()[i], moments.data()[i]) * 255.0f + 0.5f;
        directions.data()[i] = u8vec4(u8vec4::value_type(encoded.x), u8vec4::value_type(encoded.y),
                                      u8vec4::value_type(encoded.z), directions.data()[i].w);
    }
}

void composePages(BakedScene& baked, const std::vector<vec3>& weights)
{
    std::vector<ImageRgb32f> pages;
    float brightest = 0.0f;
    for (std::size_t p = 0; p < baked.lightmaps.size(); ++p) {
        ImageRgb32f light(baked.lightmaps[p].width(), baked.lightmaps[p].height());
        const bool directional = !baked.lightmapDirections.empty();
        ImageRgb32f moments;
        if (directional) moments = ImageRgb32f(light.width(), light.height());
        addPage({&baked.lightmaps[p], directional ? &baked.lightmapDirections[p] : nullptr, baked.lightmapUnitLux},
                light, moments);
        for (std::size_t g = 0; g < baked.groups.size(); ++g) {
            const BakedGroup& group = baked.groups[g];
            if (group.lightmaps[p].empty() || weights[g] == vec3(0.0f)) continue;
            const bool hasDirections = !group.directions.empty() && !group.directions[p].empty();
            addPage({&group.lightmaps[p], hasDirections ? &group.directions[p] : nullptr, group.unitLux, weights[g]},
                    light, moments);
        }
        if (directional) encodeDirectionsOf(light, moments, baked.lightmapDirections[p]);
        for (const vec3 texel : light.texels()) brightest = std::max({brightest, texel.x, texel.y, texel.z});
        pages.push_back(std::move(light));
    }
    baked.lightmapUnitLux = 1.0f;
    while (brightest > kMaxRgb9e5 * baked.lightmapUnitLux) baked.lightmapUnitLux *= 2.0f;
    for (std::size_t p = 0; p < pages.size(); ++p) baked.lightmaps[p] = encodeRgb9e5(pages[p], baked.lightmapUnitLux);
}

std::string nameOfTurning(const BakedScene& baked, const Light& light)
{
    const std::string& first = baked.groups[std::size_t(light.baking.turning.group)].name;
    const std::string last = nameOfDirection("", 0);
    return first.ends_with(last) ? first.substr(0, first.size() - last.size()) : first;
}

Error noGroup(const BakedScene& baked, const std::string& name)
{
    std::string names;
    for (const GroupWeight& other : settableWeights(baked, savedWeights(baked)))
        names += (names.empty() ? "" : ", ") + other.name;
    const bool ofSky = name == "sky" || name.starts_with("sky.");
    return {ErrorCode::InvalidArgument,
            "has no light group \"" + name + "\"" + (names.empty() ? ", nor any other" : "; its groups are " + names) +
                (ofSky ? ": give the scene halflight_sky_changes = 1, and bake it again" : ""),
            ""};
}

} // namespace

Status changeGroupWeight(const BakedScene& baked, const GroupWeight& change, std::vector<vec3>& weights)
{
    const auto isNamed = [&](const BakedGroup& group) { return group.name == change.name; };
    // "sky" stands for all parts of a sky that changes.
    const bool parts = change.name == "sky" && std::ranges::none_of(baked.groups, isNamed);
    bool found = false;
    for (int c = 0; c < 3; ++c)
        if (!(change.weight[c] >= 0.0f && change.weight[c] <= kMostGroupWeight))
            return Error{ErrorCode::InvalidArgument,
                         "the weight of light group \"" + change.name + "\" is not a number of 0 to 10^12", ""};
    for (const Light& light : baked.scene.lights) {
        if (!turns(light)) continue;
        const std::string name = nameOfTurning(baked, light);
        if (name == change.name) {
            setTurning(light, change.weight, weights);
            return {};
        }
        for (std::size_t d = 0; d < light.baking.turning.directions.size(); ++d)
            if (change.name == nameOfDirection(name, d))
                return Error{ErrorCode::InvalidArgument,
                             "light group \"" + change.name + "\" is of one direction of light \"" + light.name +
                                 "\" and follows it: turn the light, or set \"" + name + "\"",
                             ""};
    }
    for (std::size_t g = 0; g < baked.groups.size(); ++g) {
        if (parts ? !baked.groups[g].name.starts_with("sky.") : !isNamed(baked.groups[g])) continue;
        weights[g] = change.weight;
        found = true;
    }
    if (!found) return noGroup(baked, change.name);
    return {};
}

std::vector<vec3> savedWeights(const BakedScene& baked)
{
    std::vector<vec3> weights;
    for (const BakedGroup& group : baked.groups) weights.push_back(group.weight);
    if (!weights.empty()) followTurningLights(baked.scene.lights, weights);
    return weights;
}

std::vector<GroupWeight> settableWeights(const BakedScene& baked, std::span<const vec3> weights)
{
    std::vector<GroupWeight> list;
    for (std::size_t g = 0; g < weights.size();) {
        const auto ofGroup = [&](const Light& light) { return light.baking.turning.group == int(g); };
        const auto light = std::ranges::find_if(baked.scene.lights, ofGroup);
        if (light != baked.scene.lights.end()) {
            list.push_back({nameOfTurning(baked, *light), weightOfTurning(*light, weights)});
            g += light->baking.turning.directions.size();
        } else {
            list.push_back({baked.groups[g].name, weights[g]});
            ++g;
        }
    }
    return list;
}

Result<std::vector<vec3>> groupWeights(const BakedScene& baked, const std::vector<GroupWeight>& changes)
{
    std::vector<vec3> weights = savedWeights(baked);
    for (const GroupWeight& change : changes)
        if (Status s = changeGroupWeight(baked, change, weights); !s) return s.error();
    return weights;
}

std::vector<SphericalHarmonicsL2> composedRadiance(const BakedScene& baked, std::span<const vec3> weights)
{
    std::vector<SphericalHarmonicsL2> radiance;
    for (const Probe& probe : baked.probes.probes) radiance.push_back(probe.radiance);
    for (std::size_t g = 0; g < baked.groups.size(); ++g)
        for (std::size_t i = 0; i < baked.groups[g].radiance.size(); ++i)
            for (std::size_t k = 0; k < 9; ++k) radiance[i][k] += weights[g] * baked.groups[g].radiance[i][k];
    return radiance;
}

void composeGroups(BakedScene& baked, const std::vector<vec3>& weights)
{
    if (baked.groups.empty()) return;
    composePages(baked, weights);
    baked.reflections = composedReflections(baked, weights);
    baked.defaultShadowColor = subtractiveShadowColor(baked, weights);
    const std::vector<SphericalHarmonicsL2> radiance = composedRadiance(baked, weights);
    for (std::size_t i = 0; i < radiance.size(); ++i) baked.probes.probes[i].radiance = radiance[i];
    composeMembers(baked.scene, baked.groups, weights, baked.scene);
    baked.scene.sky = composedSky(baked.scene.sky, baked.groups, weights);
    for (Light& light : baked.scene.lights) {
        if (turns(light)) light.baking.worldFromLight = light.worldFromLight;
        light.baking.turning = {};
        light.baking.group = -1;
    }
    for (Material& material : baked.scene.materials) material.bakedGroup = -1;
    baked.groups.clear();
}

} // namespace halflight
