#include "render/scene/frame_bindings.h"

#include "render/scene/gpu_layout.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace halflight {

/// The texture array is declared this long at most; a scene's set holds as many as it needs.
constexpr uint32_t kMaxTextures = 65536;

std::vector<gpu::Binding> frameBindings(const gpu::Device& device)
{
    const VkPhysicalDeviceLimits& limits = device.properties().limits;
    const uint32_t images = std::min({limits.maxPerStageDescriptorSampledImages, limits.maxPerStageDescriptorSamplers,
                                      limits.maxDescriptorSetSamplers, limits.maxDescriptorSetSampledImages});
    const uint32_t textures = std::min({kMaxTextures, images - 19 /* others */, limits.maxPerStageResources - 33});
    std::vector<gpu::Binding> bindings(shading::kBindTextures + 1);
    bindings[shading::kBindFrame].type = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
    for (int i = shading::kBindLightmaps; i <= shading::kBindTextures; ++i)
        bindings[std::size_t(i)] = {VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, VK_SHADER_STAGE_FRAGMENT_BIT};
    bindings[shading::kBindProbeVolumes].type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
    bindings[shading::kBindReflectionProbes].type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
    bindings[shading::kBindTextures].count = textures;
    bindings[shading::kBindTextures].variableCount = true;
    return bindings;
}

} // namespace halflight
