#include "render/passes/display_pass.h"

#include "shaders/display.frag.h"
#include "shaders/sky.vert.h"

namespace halflight {

bool encodesSrgb(VkFormat format)
{
    return format == VK_FORMAT_R8G8B8A8_SRGB || format == VK_FORMAT_B8G8R8A8_SRGB ||
           format == VK_FORMAT_A8B8G8R8_SRGB_PACK32;
}

gpu::UniquePipeline makeDisplayPipeline(const gpu::Device& device, VkPipelineLayout layout, VkFormat format)
{
    const gpu::UniqueShader vertex = gpu::makeShader(device, sky_vert);
    const gpu::UniqueShader fragment = gpu::makeShader(device, display_frag);
    gpu::GraphicsPipelineInfo info;
    info.layout = layout;
    info.vertex = vertex.get();
    info.fragment = fragment.get();
    info.colorFormats = {format};
    info.depthTest = false;
    info.depthWrite = false;
    return gpu::makePipeline(device, info);
}

void drawDisplay(const PassContext& context, VkPipeline pipeline, const VulkanTarget& target, ivec2 size)
{
    const ivec2 end = target.end == ivec2(0) ? size : glm::min(target.end, size);
    const VkRenderingAttachmentInfo attachment{.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                               .imageView = target.view,
                                               .imageLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                                               .loadOp = VK_ATTACHMENT_LOAD_OP_LOAD,
                                               .storeOp = VK_ATTACHMENT_STORE_OP_STORE};
    beginRendering(context, {&attachment, 1}, std::nullopt, size);
    setScissor(context, target.begin, glm::max(end - target.begin, ivec2(0)));
    drawWholePicture(context, pipeline);
    endRendering(context);
}

} // namespace halflight
