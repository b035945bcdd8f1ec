#pragma once
// The compose pass (spec S33): adds up the pages of light groups. Recorded in frames before which a weight changed.

#include "gpu/pipeline.h"
#include "render/scene/light_groups.h"

namespace halflight {

/// Of one format of the sum (composedFormat()).
struct ComposePipeline {
    ComposePipeline(const gpu::Device& device, VkFormat format);

    /// A set for sources as GroupPages::sources() has them and the images that they are composed into.
    [[nodiscard]] gpu::DescriptorSet makeSet(const gpu::Device& device, const GroupPages& groups,
                                             const gpu::Buffer& sources, const gpu::Image& light,
                                             const gpu::Image& directions, VkSampler texels) const;

    std::vector<gpu::Binding> bindings;
    gpu::UniqueSetLayout setLayout;
    gpu::UniquePipelineLayout layout;
    gpu::UniquePipeline pipeline;
};

/// Fills both images, which fragment shaders then read.
void composePages(const gpu::Device& device, VkCommandBuffer commands, const ComposePipeline& pipeline,
                  VkDescriptorSet set, const GroupPages& groups, const gpu::Image& light, const gpu::Image& directions);

} // namespace halflight
