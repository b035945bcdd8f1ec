#include "gpu/pipeline.h"

#include <array>
#include <cassert>

namespace halflight::gpu {

UniqueShader makeShader(const Device& device, std::span<const uint32_t> spirv)
{
    const VkShaderModuleCreateInfo info{
        .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO, .codeSize = spirv.size_bytes(), .pCode = spirv.data()};
    VkShaderModule shader = VK_NULL_HANDLE;
    check(device.vk.CreateShaderModule(device.handle(), &info, nullptr, &shader), "create a shader");
    return {device, shader};
}

UniqueSetLayout makeSetLayout(const Device& device, std::span<const Binding> bindings)
{
    std::vector<VkDescriptorSetLayoutBinding> layoutBindings;
    std::vector<VkDescriptorBindingFlags> flags;
    for (const Binding& binding : bindings) {
        layoutBindings.push_back({.binding = uint32_t(layoutBindings.size()),
                                  .descriptorType = binding.type,
                                  .descriptorCount = binding.count,
                                  .stageFlags = binding.stages});
        flags.push_back(binding.variableCount ? VK_DESCRIPTOR_BINDING_VARIABLE_DESCRIPTOR_COUNT_BIT |
                                                    VK_DESCRIPTOR_BINDING_PARTIALLY_BOUND_BIT
                                              : 0);
    }
    const VkDescriptorSetLayoutBindingFlagsCreateInfo flagsInfo{
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_BINDING_FLAGS_CREATE_INFO,
        .bindingCount = uint32_t(flags.size()),
        .pBindingFlags = flags.data()};
    const VkDescriptorSetLayoutCreateInfo info{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
                                               .pNext = &flagsInfo,
                                               .bindingCount = uint32_t(layoutBindings.size()),
                                               .pBindings = layoutBindings.data()};
    VkDescriptorSetLayout layout = VK_NULL_HANDLE;
    check(device.vk.CreateDescriptorSetLayout(device.handle(), &info, nullptr, &layout),
          "create a descriptor set layout");
    return {device, layout};
}

DescriptorSet::DescriptorSet(const Device& device, VkDescriptorSetLayout layout, std::span<const Binding> bindings,
                             uint32_t variableCount)
    : device_(&device)
{
    std::vector<VkDescriptorPoolSize> sizes;
    bool variable = false;
    for (const Binding& binding : bindings) {
        types_.push_back(binding.type);
        sizes.push_back({binding.type, binding.variableCount ? std::max(variableCount, 1u) : binding.count});
        variable |= binding.variableCount;
    }
    const VkDescriptorPoolCreateInfo poolInfo{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                              .maxSets = 1,
                                              .poolSizeCount = uint32_t(sizes.size()),
                                              .pPoolSizes = sizes.data()};
    VkDescriptorPool pool = VK_NULL_HANDLE;
    check(device.vk.CreateDescriptorPool(device.handle(), &poolInfo, nullptr, &pool), "create a descriptor pool");
    pool_ = {device, pool};
    const VkDescriptorSetVariableDescriptorCountAllocateInfo countInfo{
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_VARIABLE_DESCRIPTOR_COUNT_ALLOCATE_INFO,
        .descriptorSetCount = 1,
        .pDescriptorCounts = &variableCount};
    const VkDescriptorSetAllocateInfo info{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                           .pNext = variable ? &countInfo : nullptr,
                                           .descriptorPool = pool,
                                           .descriptorSetCount = 1,
                                           .pSetLayouts = &layout};
    check(device.vk.AllocateDescriptorSets(device.handle(), &info, &set_), "create a descriptor set");
}

void DescriptorSet::buffer(uint32_t binding, const Buffer& buffer)
{
    const VkDescriptorBufferInfo info{buffer.get(), 0, VK_WHOLE_SIZE};
    const VkWriteDescriptorSet write{.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                     .dstSet = set_,
                                     .dstBinding = binding,
                                     .descriptorCount = 1,
                                     .descriptorType = types_[binding],
                                     .pBufferInfo = &info};
    device_->vk.UpdateDescriptorSets(device_->handle(), 1, &write, 0, nullptr);
}

void DescriptorSet::image(uint32_t binding, VkImageView view, VkSampler sampler, uint32_t element)
{
    const VkDescriptorImageInfo info{sampler, view, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
    const VkWriteDescriptorSet write{.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                     .dstSet = set_,
                                     .dstBinding = binding,
                                     .dstArrayElement = element,
                                     .descriptorCount = 1,
                                     .descriptorType = types_[binding],
                                     .pImageInfo = &info};
    device_->vk.UpdateDescriptorSets(device_->handle(), 1, &write, 0, nullptr);
}

void DescriptorSet::storageImage(uint32_t binding, VkImageView view)
{
    const VkDescriptorImageInfo info{VK_NULL_HANDLE, view, VK_IMAGE_LAYOUT_GENERAL};
    const VkWriteDescriptorSet write{.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                     .dstSet = set_,
                                     .dstBinding = binding,
                                     .descriptorCount = 1,
                                     .descriptorType = types_[binding],
                                     .pImageInfo = &info};
    device_->vk.UpdateDescriptorSets(device_->handle(), 1, &write, 0, nullptr);
}

UniquePipelineLayout makePipelineLayout(const Device& device, VkDescriptorSetLayout set, uint32_t pushConstantBytes,
                                        VkShaderStageFlags stages)
{
    const VkPushConstantRange range{stages, 0, pushConstantBytes};
    const VkPipelineLayoutCreateInfo info{.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                          .setLayoutCount = 1,
                                          .pSetLayouts = &set,
                                          .pushConstantRangeCount = pushConstantBytes > 0 ? 1u : 0u,
                                          .pPushConstantRanges = &range};
    VkPipelineLayout layout = VK_NULL_HANDLE;
    check(device.vk.CreatePipelineLayout(device.handle(), &info, nullptr, &layout), "create a pipeline layout");
    return {device, layout};
}

UniquePipeline makeComputePipeline(const Device& device, VkPipelineLayout layout, std::span<const uint32_t> spirv)
{
    const UniqueShader shader = makeShader(device, spirv);
    const VkComputePipelineCreateInfo info{.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
                                           .stage = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                                                     .stage = VK_SHADER_STAGE_COMPUTE_BIT,
                                                     .module = shader.get(),
                                                     .pName = "main"},
                                           .layout = layout};
    VkPipeline pipeline = VK_NULL_HANDLE;
    check(device.vk.CreateComputePipelines(device.handle(), VK_NULL_HANDLE, 1, &info, nullptr, &pipeline),
          "create a compute pipeline");
    return {device, pipeline};
}

/// How each of the pipeline's colours goes to its target.
static std::vector<VkPipelineColorBlendAttachmentState> blendAttachments(const GraphicsPipelineInfo& info)
{
    const VkColorComponentFlags allComponents =
        VK_COLOR_COMPONENT_R_BIT | VK_COLOR_COMPONENT_G_BIT | VK_COLOR_COMPONENT_B_BIT | VK_COLOR_COMPONENT_A_BIT;
    VkBlendFactor source = VK_BLEND_FACTOR_ONE;
    VkBlendFactor target = VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA;
    if (info.blend == Blend::Add) target = VK_BLEND_FACTOR_ONE;
    if (info.blend == Blend::Multiply) {
        source = VK_BLEND_FACTOR_ZERO;
        target = VK_BLEND_FACTOR_SRC_COLOR; // of the alpha component, the source's alpha
    }
    return std::vector<VkPipelineColorBlendAttachmentState>(info.colorFormats.size(),
                                                            {.blendEnable = info.blend != Blend::Replace,
                                                             .srcColorBlendFactor = source,
                                                             .dstColorBlendFactor = target,
                                                             .srcAlphaBlendFactor = source,
                                                             .dstAlphaBlendFactor = target,
                                                             .colorWriteMask = allComponents});
}

UniquePipeline makePipeline(const Device& device, const GraphicsPipelineInfo& info)
{
    std::vector<VkSpecializationMapEntry> entries;
    for (uint32_t i = 0; i < info.constants.size(); ++i) entries.push_back({i, i * 4u, 4u});
    const VkSpecializationInfo specialization{uint32_t(entries.size()), entries.data(),
                                              info.constants.size() * sizeof(uint32_t), info.constants.data()};
    std::vector<VkPipelineShaderStageCreateInfo> stages;
    auto addStage = [&](VkShaderStageFlagBits stage, VkShaderModule module) {
        stages.push_back({.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                          .stage = stage,
                          .module = module,
                          .pName = "main",
                          .pSpecializationInfo = &specialization});
    };
    addStage(VK_SHADER_STAGE_VERTEX_BIT, info.vertex);
    if (info.fragment) addStage(VK_SHADER_STAGE_FRAGMENT_BIT, info.fragment);

    const VkPipelineVertexInputStateCreateInfo vertexInput{
        .sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO,
        .vertexBindingDescriptionCount = uint32_t(info.vertexBindings.size()),
        .pVertexBindingDescriptions = info.vertexBindings.data(),
        .vertexAttributeDescriptionCount = uint32_t(info.vertexAttributes.size()),
        .pVertexAttributeDescriptions = info.vertexAttributes.data()};
    const VkPipelineInputAssemblyStateCreateInfo assembly{
        .sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO,
        .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST};
    const VkPipelineViewportStateCreateInfo viewport{
        .sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO, .viewportCount = 1, .scissorCount = 1};
    const VkPipelineRasterizationStateCreateInfo raster{.sType =
                                                            VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO,
                                                        .polygonMode = VK_POLYGON_MODE_FILL,
                                                        .depthBiasEnable = info.depthBias,
                                                        .lineWidth = 1.0f};
    const VkPipelineMultisampleStateCreateInfo multisample{.sType =
                                                               VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO,
                                                           .rasterizationSamples = VK_SAMPLE_COUNT_1_BIT};
    const VkPipelineDepthStencilStateCreateInfo depth{.sType =
                                                          VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO,
                                                      .depthTestEnable = info.depthTest,
                                                      .depthWriteEnable = info.depthWrite,
                                                      .depthCompareOp = info.depthCompare};
    const std::vector<VkPipelineColorBlendAttachmentState> attachments = blendAttachments(info);
    const VkPipelineColorBlendStateCreateInfo blend{.sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO,
                                                    .attachmentCount = uint32_t(attachments.size()),
                                                    .pAttachments = attachments.data()};
    std::vector<VkDynamicState> dynamicStates{VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR,
                                              VK_DYNAMIC_STATE_CULL_MODE, VK_DYNAMIC_STATE_FRONT_FACE};
    if (info.depthBias) dynamicStates.push_back(VK_DYNAMIC_STATE_DEPTH_BIAS);
    const VkPipelineDynamicStateCreateInfo dynamic{.sType = VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO,
                                                   .dynamicStateCount = uint32_t(dynamicStates.size()),
                                                   .pDynamicStates = dynamicStates.data()};
    const VkPipelineRenderingCreateInfo rendering{.sType = VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO,
                                                  .colorAttachmentCount = uint32_t(info.colorFormats.size()),
                                                  .pColorAttachmentFormats = info.colorFormats.data(),
                                                  .depthAttachmentFormat = info.depthFormat};
    const VkGraphicsPipelineCreateInfo pipelineInfo{.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
                                                    .pNext = &rendering,
                                                    .stageCount = uint32_t(stages.size()),
                                                    .pStages = stages.data(),
                                                    .pVertexInputState = &vertexInput,
                                                    .pInputAssemblyState = &assembly,
                                                    .pViewportState = &viewport,
                                                    .pRasterizationState = &raster,
                                                    .pMultisampleState = &multisample,
                                                    .pDepthStencilState = &depth,
                                                    .pColorBlendState = &blend,
                                                    .pDynamicState = &dynamic,
                                                    .layout = info.layout};
    VkPipeline pipeline = VK_NULL_HANDLE;
    check(device.vk.CreateGraphicsPipelines(device.handle(), VK_NULL_HANDLE, 1, &pipelineInfo, nullptr, &pipeline),
          "create a graphics pipeline");
    return {device, pipeline};
}

} // namespace halflight::gpu
