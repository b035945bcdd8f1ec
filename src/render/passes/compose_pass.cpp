#include "render/passes/compose_pass.h"

#include "shaders/compose.comp.h"
#include "shaders/compose_half.comp.h"

namespace halflight {
namespace {

std::vector<gpu::Binding> composeBindings()
{
    std::vector<gpu::Binding> bindings(shading::kBindComposedDirections + 1);
    for (gpu::Binding& binding : bindings) binding.stages = VK_SHADER_STAGE_COMPUTE_BIT;
    for (const int i : {shading::kBindSourcePages, shading::kBindSourceDirections})
        bindings[std::size_t(i)].type = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
    for (const int i : {shading::kBindComposedPages, shading::kBindComposedDirections})
        bindings[std::size_t(i)].type = VK_DESCRIPTOR_TYPE_STORAGE_IMAGE;
    return bindings;
}

} // namespace

ComposePipeline::ComposePipeline(const gpu::Device& device, VkFormat format)
    : bindings(composeBindings()), setLayout(gpu::makeSetLayout(device, bindings)),
      layout(gpu::makePipelineLayout(device, setLayout.get(), sizeof(shading::GpuCompose), VK_SHADER_STAGE_COMPUTE_BIT))
{
    pipeline = format == VK_FORMAT_R16G16B16A16_SFLOAT
                   ? gpu::makeComputePipeline(device, layout.get(), compose_half_comp)
                   : gpu::makeComputePipeline(device, layout.get(), compose_comp);
}

gpu::DescriptorSet ComposePipeline::makeSet(const gpu::Device& device, const GroupPages& groups,
                                            const gpu::Buffer& sources, const gpu::Image& light,
                                            const gpu::Image& directions, VkSampler texels) const
{
    gpu::DescriptorSet set(device, setLayout.get(), bindings, 0);
    set.image(shading::kBindSourcePages, groups.pages().view(), texels);
    set.image(shading::kBindSourceDirections, groups.directions().view(), texels);
    set.buffer(shading::kBindSources, sources);
    set.storageImage(shading::kBindComposedPages, light.storageView());
    set.storageImage(shading::kBindComposedDirections, directions.storageView());
    return set;
}

void composePages(const gpu::Device& device, VkCommandBuffer commands, const ComposePipeline& pipeline,
                  VkDescriptorSet set, const GroupPages& groups, const gpu::Image& light, const gpu::Image& directions)
{
    // Frames before may still read what is written over.
    for (const gpu::Image* image : {&light, &directions})
        gpu::transition(device, commands, *image, gpu::state::kReused, gpu::state::kComputeWrite);
    const ivec2 size = groups.size();
    const uint32_t pages = light.info().layers;
    const shading::GpuCompose push{ivec4(size, groups.listLength(), groups.hasDirections() ? 1 : 0)};
    device.vk.CmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.pipeline.get());
    device.vk.CmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.layout.get(), 0, 1, &set, 0,
                                    nullptr);
    device.vk.CmdPushConstants(commands, pipeline.layout.get(), VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(push), &push);
    const auto groupsAlong = [](int texels) {
        return uint32_t((texels + shading::kComposeSide - 1) / shading::kComposeSide);
    };
    device.vk.CmdDispatch(commands, groupsAlong(size.x), groupsAlong(size.y), pages);
    for (const gpu::Image* image : {&light, &directions})
        gpu::transition(device, commands, *image, gpu::state::kComputeWrite, gpu::state::kFragmentRead);
}

} // namespace halflight
