#include "render/scene/reflections.h"

#include "render/scene/gpu_layout.h"

#include <vector>

namespace halflight {

ReflectionTextures uploadReflections(gpu::Device& device, gpu::Uploader& uploader, const ReflectionSet& set)
{
    ReflectionTextures result;
    result.count = int(set.probes.size());
    result.size = set.size;
    result.unitNits = set.unitNits;
    std::vector<shading::GpuReflectionProbe> probes;
    for (const ReflectionProbe& probe : set.probes) {
        const mat3 axes(probe.worldFromBox);
        shading::GpuReflectionProbe& out = probes.emplace_back();
        out.boxFromWorld = glm::inverse(probe.worldFromBox);
        out.position = vec4(probe.position, probe.fadeMeters);
        out.halfSize = vec4(glm::length(axes[0]), glm::length(axes[1]), glm::length(axes[2]), 0.0f);
    }
    if (probes.empty()) probes.emplace_back();
    const std::size_t bytes = probes.size() * sizeof(probes[0]);
    result.probes = gpu::Buffer(device, bytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                                gpu::MemoryUse::Device);
    uploader.buffer(result.probes, probes.data(), bytes);
    const uint32_t black = 0;
    const bool none = set.picture.empty();
    result.picture = gpu::Image(device, {.format = VK_FORMAT_E5B9G9R9_UFLOAT_PACK32,
                                         .width = none ? 1 : uint32_t(set.picture.width()),
                                         .height = none ? 1 : uint32_t(set.picture.height()),
                                         .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT});
    uploader.image(result.picture, {{{0, 0, none ? &black : set.picture.data()}}}, 4);
    uploader.finish();
    return result;
}

void updateReflections(gpu::Uploader& uploader, const ReflectionSet& set, ReflectionTextures& textures)
{
    if (set.picture.empty()) return;
    textures.unitNits = set.unitNits;
    uploader.image(textures.picture, {{{0, 0, set.picture.data()}}}, 4);
    uploader.finish();
}

vec4 reflectionsOfFrame(const ReflectionTextures& textures)
{
    return {float(textures.count), float(textures.size), textures.unitNits, 0.0f};
}

} // namespace halflight
