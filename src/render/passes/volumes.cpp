#include "render/passes/volumes.h"

#include "shaders/absorb.frag.h"
#include "shaders/sky.vert.h"
#include "shaders/volume.frag.h"
#include "shaders/volume.vert.h"

namespace halflight {

VolumePasses::VolumePasses(const gpu::Device& device, VkPipelineLayout layout, VkFormat colorFormat)
    : format(colorFormat)
{
    const gpu::UniqueShader volumeVertex = gpu::makeShader(device, volume_vert);
    const gpu::UniqueShader volumeFragment = gpu::makeShader(device, volume_frag);
    gpu::GraphicsPipelineInfo faces;
    faces.layout = layout;
    faces.vertex = volumeVertex.get();
    faces.fragment = volumeFragment.get();
    faces.vertexBindings = {{0, sizeof(vec3), VK_VERTEX_INPUT_RATE_VERTEX}};
    faces.vertexAttributes = {{0, 0, VK_FORMAT_R32G32B32_SFLOAT, 0}};
    faces.colorFormats = {format};
    faces.depthTest = false;
    faces.depthWrite = false;
    faces.blend = gpu::Blend::Add;
    add = gpu::makePipeline(device, faces);

    const gpu::UniqueShader pictureVertex = gpu::makeShader(device, sky_vert);
    const gpu::UniqueShader absorbFragment = gpu::makeShader(device, absorb_frag);
    gpu::GraphicsPipelineInfo whole;
    whole.layout = layout;
    whole.vertex = pictureVertex.get();
    whole.fragment = absorbFragment.get();
    whole.colorFormats = {colorFormat};
    whole.depthTest = false;
    whole.depthWrite = false;
    whole.blend = gpu::Blend::Multiply;
    absorb = gpu::makePipeline(device, whole);
}

void VolumePasses::ensure(const gpu::Device& device, ivec2 size)
{
    if (depths.get() && depths.info().width == uint32_t(size.x) && depths.info().height == uint32_t(size.y)) return;
    device.waitIdle(); // frames in flight use the image before
    depths = {};
    depths = gpu::Image(device, {.format = format,
                                 .width = uint32_t(size.x),
                                 .height = uint32_t(size.y),
                                 .usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT});
}

void drawVolumes(const PassContext& context, const VolumePasses& passes, const gpu::Image& color,
                 const gpu::Image& depth, const CameraDraws& draws)
{
    const gpu::Device& device = context.device;
    VkCommandBuffer commands = context.commands;
    gpu::transition(device, commands, passes.depths, gpu::state::kReused, gpu::state::kColorAttachment);
    gpu::transition(device, commands, depth, gpu::state::kDepthAttachment, gpu::state::kFragmentRead);
    drawAllFaces(context, passes.add.get(), passes.depths, draws.clipFromWorld, draws.volumes);
    gpu::transition(device, commands, passes.depths, gpu::state::kColorAttachment, gpu::state::kFragmentRead);
    gpu::transition(device, commands, depth, gpu::state::kFragmentRead, gpu::state::kDepthAttachment);
    gpu::transition(device, commands, color, gpu::state::kColorAttachment, gpu::state::kColorAttachment);
    drawOverPicture(context, passes.absorb.get(), color);
    gpu::transition(device, commands, color, gpu::state::kColorAttachment, gpu::state::kColorAttachment);
}

} // namespace halflight
