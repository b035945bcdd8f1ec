// The renderer trusts no index: an engine may have filled the scene itself.
#include "render/scene/gpu_scene.h"

#include "halflight/base/finite.h"
#include "halflight/render/compose.h"
#include "halflight/render/frame.h"
#include "halflight/scene/light_groups.h"
#include "halflight/scene/turning_lights.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

namespace halflight {
namespace {

Error broken(std::string message, std::string object)
{
    return {ErrorCode::FileInvalid, std::move(message), std::move(object)};
}

std::string path(const char* kind, std::size_t index)
{
    return std::string("/") + kind + "/" + std::to_string(index);
}

Status checkPart(const Scene& scene, const MeshPart& part, const std::string& where)
{
    const std::size_t count = part.positions.size();
    auto fits = [&](const auto& array) { return array.empty() || array.size() == count; };
    if (!fits(part.normals) || !fits(part.tangents) || !std::all_of(part.uv.begin(), part.uv.end(), fits) ||
        !fits(part.colors) || !fits(part.lightmapUv))
        return broken("vertex attributes differ in length", where);
    if (part.indices.size() % 3 != 0) return broken("the number of indices is no multiple of 3", where);
    if (std::any_of(part.indices.begin(), part.indices.end(), [&](uint32_t index) { return index >= count; }))
        return broken("an index lies beyond the vertices", where);
    if (part.material >= int(scene.materials.size())) return broken("the material does not exist", where);
    return {};
}

/// Pages of a light group beside those of the rest.
Status checkGroup(const BakedScene& baked, const BakedGroup& group)
{
    const auto wrong = [&](const char* what) { return broken(what, "light group \"" + group.name + "\""); };
    for (int c = 0; c < 3; ++c)
        if (!(group.weight[c] >= 0.0f && group.weight[c] <= kMostGroupWeight))
            return wrong("the weight is out of range");
    if (!(group.unitLux > 0.0f) || !std::isfinite(group.unitLux)) return wrong("the unit is not a number above 0");
    if (group.lightmaps.size() != baked.lightmaps.size()) return wrong("there are not as many pages as the rest has");
    if (!group.directions.empty() && group.directions.size() != baked.lightmapDirections.size())
        return wrong("there are not as many direction pages as the rest has");
    for (std::size_t p = 0; p < group.lightmaps.size(); ++p) {
        const auto fits = [&](const auto& page) { return page.empty() || page.size() == baked.lightmaps[p].size(); };
        if (!fits(group.lightmaps[p]) || (!group.directions.empty() && !fits(group.directions[p])))
            return wrong("a page has another size than the rest's");
    }
    if (!group.radiance.empty() && group.radiance.size() != baked.probes.probes.size())
        return wrong("it has not the light of as many probes as there are");
    return {};
}

Status checkGroups(const BakedScene& baked)
{
    const int count = int(baked.groups.size());
    if (baked.groups.size() > kMostLightGroups) return broken("there are more than 16 light groups", "");
    for (const BakedGroup& group : baked.groups)
        if (Status status = checkGroup(baked, group); !status) return status;
    for (const Light& light : baked.scene.lights)
        if (count > 0 && light.baking.group >= count) return broken("its light group does not exist", light.name);
    for (const Light& light : baked.scene.lights) {
        const TurningLight& turning = light.baking.turning;
        if (turns(light) && (turning.directions.empty() ||
                             std::size_t(turning.group) + turning.directions.size() > baked.groups.size()))
            return broken("the light groups of its directions do not exist", light.name);
    }
    for (const Material& material : baked.scene.materials)
        if (count > 0 && material.bakedGroup >= count) return broken("its light group does not exist", material.name);
    return {};
}

} // namespace

Status checkScene(const BakedScene& baked)
{
    const Scene& scene = baked.scene;
    for (std::size_t i = 0; i < scene.materials.size(); ++i) {
        const Material& material = scene.materials[i];
        std::set<int> sets;
        for (const TextureRef* ref : material.textureRefs()) {
            if (ref->texture >= int(scene.textures.size()))
                return broken("the texture does not exist", path("materials", i));
            if (ref->texCoord < 0 || ref->texCoord >= kTexCoordSets)
                return broken("only texture coordinate sets 0 to 7 can be used", path("materials", i));
            if (*ref) sets.insert(ref->texCoord);
        }
        if (sets.size() > 2)
            return broken("its textures read more than two texture coordinate sets", path("materials", i));
    }
    for (std::size_t i = 0; i < scene.meshes.size(); ++i)
        for (std::size_t j = 0; j < scene.meshes[i].parts.size(); ++j)
            if (Status status = checkPart(scene, scene.meshes[i].parts[j], path("meshes", i) + path("primitives", j));
                !status)
                return status;
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
        const Object& object = scene.objects[i];
        if (object.mesh >= int(scene.meshes.size())) return broken("the mesh does not exist", path("objects", i));
        if (object.lightmap.page >= int(baked.lightmaps.size()) && baked.isBaked)
            return broken("the lightmap page does not exist", path("objects", i));
    }
    for (const Light& light : scene.lights)
        if (light.baking.occlusionMaskChannel < -1 ||
            light.baking.occlusionMaskChannel >= baked.maskLayers * kLayerChannels)
            return broken("a shadowmask channel is outside the mask's layers", light.name);
    for (const Light& light : scene.lights)
        if (light.baking.coloredMask &&
            (light.baking.occlusionMaskChannel < 0 || light.baking.occlusionMaskChannel % kLayerChannels != 0))
            return broken("a coloured mask is not in the first three channels of a layer", light.name);
    if (baked.maskLayers < 1 || baked.maskLayers > kMostMaskLayers)
        return broken("there are not 1 to 4 mask layers", "");

    auto samePages = [](const auto& pages) {
        return std::all_of(pages.begin(), pages.end(),
                           [&](const auto& page) { return !page.empty() && page.size() == pages.front().size(); });
    };
    if (scene.sky.picture && scene.sky.picture->empty()) return broken("the sky's picture has no texels", "");
    if (!samePages(baked.lightmaps)) return broken("lightmap pages are empty or differ in size", "");
    if (!(baked.lightmapUnitLux > 0.0f) || !std::isfinite(baked.lightmapUnitLux))
        return broken("the lightmap's unit is not a number above 0", "");
    for (const MaskChannel& channel : baked.maskChannels)
        if (!(channel.rangeTexels >= 0.0f && channel.penumbraTexels >= 0.0f))
            return broken("a shadowmask channel has a range or penumbra below 0", "");
    const ivec2 maskSize = maskPageSize(baked);
    const bool sameMasks = std::all_of(baked.shadowmasks.begin(), baked.shadowmasks.end(), [&](const ImageRgba8& page) {
        return page.empty() ? baked.maskLayers > 1 : page.size() == maskSize;
    });
    if (!sameMasks) return broken("shadowmask pages are empty or differ in size", "");
    if (!samePages(baked.lightmapDirections)) return broken("lightmap direction pages are empty or differ in size", "");
    if (!baked.lightmapDirections.empty() && baked.lightmapDirections.size() != baked.lightmaps.size())
        return broken("the file has not as many lightmap direction pages as lightmap pages", "");
    if (!baked.shadowmasks.empty() &&
        baked.shadowmasks.size() != baked.lightmaps.size() * std::size_t(baked.maskLayers))
        return broken("the file has not as many shadowmask pages as lightmap pages", "");
    return checkGroups(baked);
}

const char* problemOf(const Light& light)
{
    const auto atLeastZero = [](float x) { return std::isfinite(x) && x >= 0.0f; };
    if (!isFinite(light.worldFromLight) || std::abs(glm::determinant(mat3(light.worldFromLight))) < 1.0e-6f)
        return "the light's transform is not finite or has no inverse";
    if (!atLeastZero(light.color.r) || !atLeastZero(light.color.g) || !atLeastZero(light.color.b))
        return "the light's colour is not finite or negative";
    if (!atLeastZero(light.intensity)) return "the light's intensity is not finite or negative";
    if (!atLeastZero(light.rangeMeters)) return "the light's range is not finite or negative";
    if (!(light.shadowStrength >= 0.0f && light.shadowStrength <= 1.0f))
        return "the light's shadow strength must be 0 to 1";
    if (!(light.innerConeRadians >= 0.0f && light.innerConeRadians <= light.outerConeRadians &&
          light.outerConeRadians <= kPi / 2.0f))
        return "the light's inner cone must be 0 to its outer cone, and that at most 90 degrees";
    const ShadowBias& bias = light.shadowBias;
    const auto within = [](const std::optional<float>& x, float most) { return !x || (*x >= 0.0f && *x <= most); };
    if (!within(bias.depthTexels, kMaxShadowBias) || !within(bias.slope, kMaxShadowBias) ||
        !within(bias.normalTexels, kMaxNormalBiasTexels))
        return "the light's biases must be 0 to 100 (depth, slope) and 0 to 8 (normal)";
    return nullptr;
}

} // namespace halflight
