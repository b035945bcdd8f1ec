#pragma once
// Shaders, descriptor sets and graphics pipelines.

#include "gpu/resources.h"

#include <cstdint>
#include <span>
#include <vector>

namespace halflight::gpu {

using UniqueShader = Unique<VkShaderModule, &Functions::DestroyShaderModule>;
using UniqueSetLayout = Unique<VkDescriptorSetLayout, &Functions::DestroyDescriptorSetLayout>;
using UniqueDescriptorPool = Unique<VkDescriptorPool, &Functions::DestroyDescriptorPool>;
using UniquePipelineLayout = Unique<VkPipelineLayout, &Functions::DestroyPipelineLayout>;
using UniquePipeline = Unique<VkPipeline, &Functions::DestroyPipeline>;

UniqueShader makeShader(const Device& device, std::span<const uint32_t> spirv);

struct Binding {
    VkDescriptorType type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
    VkShaderStageFlags stages = VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT;
    uint32_t count = 1;
    bool variableCount = false; ///< the last binding only: `count` is the most it may hold
};

/// Binding i of the set is bindings[i].
UniqueSetLayout makeSetLayout(const Device& device, std::span<const Binding> bindings);

/// One descriptor set with a pool of its own.
class DescriptorSet {
public:
    DescriptorSet() = default;
    /// `variableCount`: descriptors in the last binding when its count is variable.
    DescriptorSet(const Device& device, VkDescriptorSetLayout layout, std::span<const Binding> bindings,
                  uint32_t variableCount);

    void buffer(uint32_t binding, const Buffer& buffer);
    void image(uint32_t binding, VkImageView view, VkSampler sampler, uint32_t element = 0);
    /// An image in layout GENERAL.
    void storageImage(uint32_t binding, VkImageView view);
    [[nodiscard]] VkDescriptorSet get() const { return set_; }

private:
    const Device* device_ = nullptr;
    std::vector<VkDescriptorType> types_;
    UniqueDescriptorPool pool_;
    VkDescriptorSet set_ = VK_NULL_HANDLE;
};

/// `stages`: those that read push constants.
UniquePipelineLayout makePipelineLayout(const Device& device, VkDescriptorSetLayout set, uint32_t pushConstantBytes,
                                        VkShaderStageFlags stages = VK_SHADER_STAGE_VERTEX_BIT |
                                                                    VK_SHADER_STAGE_FRAGMENT_BIT);
UniquePipeline makeComputePipeline(const Device& device, VkPipelineLayout layout, std::span<const uint32_t> spirv);

/// What a fragment does to the target. Premultiplied: source + (1 - source alpha) * target. Add: source + target.
/// Multiply: source * target.
enum class Blend { Replace, Premultiplied, Add, Multiply };

/// Viewport, scissor, cull mode and front face are dynamic, and the depth bias where it is on.
struct GraphicsPipelineInfo {
    VkPipelineLayout layout = VK_NULL_HANDLE;
    VkShaderModule vertex = VK_NULL_HANDLE;
    VkShaderModule fragment = VK_NULL_HANDLE; ///< none: depth only
    std::vector<uint32_t> constants;          ///< specialization constant i is constants[i], in both stages
    std::vector<VkVertexInputBindingDescription> vertexBindings;
    std::vector<VkVertexInputAttributeDescription> vertexAttributes;
    std::vector<VkFormat> colorFormats;         ///< of the colour attachments
    VkFormat depthFormat = VK_FORMAT_UNDEFINED; ///< undefined: no depth attachment
    bool depthTest = true;
    bool depthWrite = true;
    VkCompareOp depthCompare = VK_COMPARE_OP_GREATER_OR_EQUAL;
    bool depthBias = false;
    Blend blend = Blend::Replace; ///< of all colour attachments
};
UniquePipeline makePipeline(const Device& device, const GraphicsPipelineInfo& info);

} // namespace halflight::gpu
