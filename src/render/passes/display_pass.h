#pragma once
// From a frame's samples to displayed pixels in an image of the caller.

#include "halflight/render/renderer.h"
#include "halflight/render/vulkan_target.h"

#include "render/passes/passes.h"

namespace halflight {

struct DisplayValues {
    float exposureEv = 0.0f;
    ToneMapping toneMapping = ToneMapping::Neutral;
    bool showsLight = true;   ///< false: samples are values from 0 to 1, shown as they are
    bool encodesSrgb = false; ///< the target's format does, so that the shader must not
    ivec2 size{1};            ///< pixels in which the picture is shown
};

bool encodesSrgb(VkFormat format);

gpu::UniquePipeline makeDisplayPipeline(const gpu::Device& device, VkPipelineLayout layout, VkFormat format);
void drawDisplay(const PassContext& context, VkPipeline pipeline, const VulkanTarget& target, ivec2 size);

} // namespace halflight
