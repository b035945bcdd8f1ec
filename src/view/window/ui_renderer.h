#pragma once
// Draws Dear ImGui's lists by Vulkan. Its own backend links Vulkan's loader, which this program opens at run time.

#include "gpu/pipeline.h"
#include "halflight/base/image.h"
#include "halflight/base/math.h"
#include "halflight/render/renderer.h"

#include <vector>

struct ImDrawData;

namespace halflight::view {

class UiRenderer {
public:
    /// Needs a current ImGui context. `format`: of the target, one that does not encode sRGB.
    UiRenderer(gpu::Device& device, VkFormat format);

    /// The picture that draw commands with kPicture show, encoded colours. Waits for the device.
    void setPicture(const ImageRgba8& picture);
    static constexpr std::size_t kPicture = 1; ///< its ImTextureID

    /// Records the lists into `target`, in layout COLOR_ATTACHMENT_OPTIMAL, over what is there. `slot` <
    /// kFramesInFlight: the device has finished what was recorded with it before.
    void draw(VkCommandBuffer commands, VkImageView target, ivec2 size, const ImDrawData& data, int slot);

private:
    struct Buffers {
        gpu::Buffer vertices;
        gpu::Buffer indices;
    };
    void upload(const ImDrawData& data, Buffers& buffers) const;
    void drawLists(VkCommandBuffer commands, ivec2 size, const ImDrawData& data) const;

    gpu::Device& device_;
    gpu::Image font_;
    gpu::Image picture_;
    gpu::UniqueSampler sampler_;
    gpu::UniqueSetLayout setLayout_;
    gpu::DescriptorSet set_;
    gpu::DescriptorSet pictureSet_; ///< empty before setPicture()
    gpu::UniquePipelineLayout layout_;
    gpu::UniquePipeline pipeline_;
    std::vector<Buffers> buffers_;
};

} // namespace halflight::view
