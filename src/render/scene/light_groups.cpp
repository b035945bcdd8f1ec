#include "render/scene/light_groups.h"

#include "halflight/base/mathematics.h"
#include "halflight/base/rgb9e5.h"
#include "halflight/render/compose.h"
#include "halflight/scene/turning_lights.h"
#include "render/scene/gpu_scene.h"
#include "render/scene/upload_pages.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>

namespace halflight {
namespace {

constexpr VkFormat kRgb9e5 = VK_FORMAT_E5B9G9R9_UFLOAT_PACK32;
constexpr VkFormat kRgb9e5AsNumbers = VK_FORMAT_R32_UINT;
constexpr VkFormat kDirectionFormat = VK_FORMAT_R8G8B8A8_UNORM;
constexpr float kHalfOfRange = 32704.0f; ///< kMaxRgb9e5 / 2

} // namespace

VkFormat composedFormat(const gpu::Device& device)
{
    return device.hasStorageView(kRgb9e5, kRgb9e5AsNumbers) ? kRgb9e5 : VK_FORMAT_R16G16B16A16_SFLOAT;
}

GroupPages::GroupPages(gpu::Device& device, gpu::Uploader& uploader, const BakedScene& baked)
    : hasDirections_(!baked.lightmapDirections.empty())
{
    std::vector<const Image<uint32_t>*> pages;
    std::vector<const ImageRgba8*> directions;
    const auto add = [&](const std::vector<Image<uint32_t>>& light, const std::vector<ImageRgba8>& ofLight,
                         float unitLux) {
        float brightest = 0.0f;
        std::vector<Layers>& layers = layers_.emplace_back(light.size());
        for (std::size_t p = 0; p < light.size(); ++p) {
            if (light[p].empty()) continue;
            brightest = std::max(brightest, brightestOf(light[p]));
            layers[p].page = int(pages.size());
            pages.push_back(&light[p]);
            if (!hasDirections_ || p >= ofLight.size() || ofLight[p].empty()) continue;
            layers[p].directions = int(directions.size());
            directions.push_back(&ofLight[p]);
        }
        unitLux_.push_back(unitLux);
        peakLux_.push_back(brightest * unitLux);
    };
    add(baked.lightmaps, baked.lightmapDirections, baked.lightmapUnitLux);
    for (const BakedGroup& group : baked.groups) add(group.lightmaps, group.directions, group.unitLux);
    pages_ = uploadLayers(device, uploader, pages, kRgb9e5, uint32_t(0));
    directions_ = uploadLayers(device, uploader, directions, kDirectionFormat, u8vec4(0));
}

gpu::Image GroupPages::makeLight(const gpu::Device& device, VkFormat format) const
{
    return gpu::Image(
        device, {.format = format,
                 .width = pages_.info().width,
                 .height = pages_.info().height,
                 .layers = uint32_t(std::max(pageCount(), 1)),
                 .array = true,
                 .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_STORAGE_BIT,
                 .storageFormat = format == kRgb9e5 ? kRgb9e5AsNumbers : format});
}

gpu::Image GroupPages::makeDirections(const gpu::Device& device) const
{
    return gpu::Image(
        device, {.format = kDirectionFormat,
                 .width = hasDirections_ ? pages_.info().width : 1,
                 .height = hasDirections_ ? pages_.info().height : 1,
                 .layers = hasDirections_ ? uint32_t(std::max(pageCount(), 1)) : 1,
                 .array = true,
                 .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_STORAGE_BIT});
}

float GroupPages::unitLux(std::span<const vec3> weights) const
{
    float most = peakLux_[0];
    for (std::size_t g = 0; g < weights.size(); ++g)
        most += peakLux_[g + 1] * std::max({weights[g].x, weights[g].y, weights[g].z});
    return most > 0.0f ? math::exp2(std::ceil(math::log2(most / kHalfOfRange))) : 1.0f;
}

std::vector<shading::GpuLightSource> GroupPages::sources(std::span<const vec3> weights) const
{
    const float unit = unitLux(weights);
    const std::size_t length = layers_.size();
    const std::size_t lists = std::size_t(std::max(pageCount(), 1)); // the stand-in for no page, which is black
    std::vector<shading::GpuLightSource> all(length * lists, {vec4(0.0f), ivec4(-1)});
    for (std::size_t p = 0; p < std::size_t(pageCount()); ++p) {
        std::size_t at = p * length;
        for (std::size_t i = 0; i < length; ++i) {
            const vec3 weight = i == 0 ? vec3(1.0f) : weights[i - 1];
            const Layers& layers = layers_[i][p];
            if (layers.page < 0 || weight == vec3(0.0f)) continue;
            all[at++] = {vec4(unitLux_[i] / unit * weight, 0.0f), ivec4(layers.page, layers.directions, 0, 0)};
        }
    }
    return all;
}

void GroupPages::raisePeak(float brightest)
{
    peakLux_[0] = std::max(peakLux_[0], brightest * unitLux_[0]);
}

namespace {

/// A sky's picture is on the device as saved, and multiplied where it is read.
SphericalHarmonicsL2 skyRadiance(const GpuScene& scene)
{
    if (!scene.outline.scene.sky.picture) return skyProbe(scene.outline.scene.sky).radiance;
    SphericalHarmonicsL2 radiance = scene.groups.savedSky;
    for (vec3& coefficient : radiance) coefficient *= scene.skyFactor;
    return radiance;
}

void lightProbes(GpuScene& scene)
{
    const SphericalHarmonicsL2 sky = skyRadiance(scene);
    for (std::size_t i = 0; i < sky.size(); ++i) scene.skySh[i] = vec4(sky[i], 0.0f);
    *scene.probes = scene.probes->withLight(composedRadiance(scene.outline, scene.groups.weights), sky);
}

} // namespace

void uploadGroups(gpu::Device& device, gpu::Uploader& uploader, const BakedScene& baked, GpuScene& scene)
{
    GroupState& state = scene.groups;
    state.pages = GroupPages(device, uploader, baked);
    scene.lightmaps = state.pages.makeLight(device, composedFormat(device));
    scene.lightmapDirections = state.pages.makeDirections(device);
    state.weights = savedWeights(baked);
    scene.reflections = uploadReflections(device, uploader, composedReflections(baked, state.weights));
    pagesOfGroupsChanged(scene);
    state.saved.lights = baked.scene.lights;
    state.saved.materials = baked.scene.materials;
    state.saved.sky = baked.scene.sky;
    state.savedSky = skyProbe(baked.scene.sky).radiance;
    lightProbes(scene);
}

void pagesOfGroupsChanged(GpuScene& scene)
{
    scene.lightmapUnitLux = scene.groups.pages.unitLux(scene.groups.weights);
    scene.groups.pagesChanged = true;
}

void setGroupWeights(GpuScene& scene, std::vector<vec3> weights)
{
    GroupState& state = scene.groups;
    const std::vector<BakedGroup>& groups = scene.outline.groups;
    composeMembers(state.saved, groups, weights, scene.outline.scene);
    if (weights == state.weights) return;
    state.weights = std::move(weights);
    scene.skyFactor = composedSkyFactor(groups, state.weights);
    if (!state.saved.sky.picture) scene.outline.scene.sky = composedSky(state.saved.sky, groups, state.weights);
    pagesOfGroupsChanged(scene);
    state.membersChanged = true;
}

Status setGroupWeight(GpuScene& scene, const std::string& name, vec3 weight)
{
    std::vector<vec3> weights = scene.groups.weights;
    if (Status s = changeGroupWeight(scene.outline, {name, weight}, weights); !s) return s;
    setGroupWeights(scene, std::move(weights));
    return {};
}

void followLight(GpuScene& scene, int light)
{
    if (scene.outline.groups.empty()) return;
    const Light& changed = scene.outline.scene.lights[std::size_t(light)];
    std::vector<vec3> weights = scene.groups.weights;
    if (turns(changed)) {
        followTurningLights({&changed, 1}, weights);
        setGroupWeights(scene, std::move(weights));
        return;
    }
    const int group = changed.baking.group;
    if (group < 0) return;
    const std::optional<vec3> weight = weightOfLights(scene.outline.scene, group, weights[std::size_t(group)]);
    if (!weight) return;
    weights[std::size_t(group)] = *weight;
    setGroupWeights(scene, std::move(weights));
}

void uploadGroupMembers(gpu::Device& device, GpuScene& scene)
{
    GroupState& state = scene.groups;
    state.membersChanged = false;
    lightProbes(scene);
    gpu::Uploader uploader(device);
    const ReflectionSet reflections = composedReflections(scene.outline, state.weights);
    updateReflections(uploader, reflections, scene.reflections);
    const std::vector<Material>& materials = scene.outline.scene.materials;
    for (std::size_t i = 0; i < materials.size(); ++i) {
        if (materials[i].bakedGroup < 0) continue;
        const vec4 emission(materials[i].emissiveNits, materials[i].metallic);
        uploader.buffer(scene.materials, &emission, sizeof(emission),
                        i * sizeof(shading::GpuMaterial) + offsetof(shading::GpuMaterial, emissiveMetallic));
    }
    uploader.finish();
    scene.changedObjects.resize(scene.outline.scene.objects.size());
    std::iota(scene.changedObjects.begin(), scene.changedObjects.end(), 0u);
}

} // namespace halflight
