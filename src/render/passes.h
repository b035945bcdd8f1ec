#pragma once
// The passes of a frame: each records its commands and nothing else.

#include "render/draw_list.h"

#include <array>
#include <span>
#include <vector>

namespace halflight {

constexpr VkFormat kDepthFormat = VK_FORMAT_D32_SFLOAT;

/// Bindings of the one descriptor set, by number as in gpu_layout.h. The last one's count is the most textures a scene
/// may have on this device.
std::vector<gpu::Binding> frameBindings(const gpu::Device& device);

/// One pipeline per pass and kind of surface.
struct Pipelines {
    Pipelines(const gpu::Device& device, VkDescriptorSetLayout set, VkFormat colorFormat);

    gpu::UniquePipelineLayout layout;
    gpu::UniquePipeline shadow;
    gpu::UniquePipeline shadowMasked;
    gpu::UniquePipeline depth;
    gpu::UniquePipeline depthMasked;
    gpu::UniquePipeline lit;
    gpu::UniquePipeline blend;
    gpu::UniquePipeline sky;
};

/// What every pass needs to record.
struct PassContext {
    const gpu::Device& device;
    const GpuScene& scene;
    const Pipelines& pipelines;
    VkDescriptorSet set;
    VkCommandBuffer commands;
};

void bindScene(const PassContext& context);

/// A shadow tile as a rectangle of a depth image.
struct ShadowDraws {
    mat4 clipFromWorld{1.0f};
    ivec2 offset{0};
    int size = 0;
    std::vector<Draw> draws;
};
/// Clears one layer to "lit" and draws tiles into it.
void drawShadowLayer(const PassContext& context, const gpu::Image& map, VkImageView layer,
                     std::span<const ShadowDraws> tiles, float slopeBias);

/// The camera's passes, within one rendering scope: depth alone, then lit where depth is equal, sky, blended surfaces.
struct CameraDraws {
    mat4 clipFromWorld{1.0f};
    std::vector<Draw> solid;
    std::vector<Draw> blended;
};
void beginCamera(const PassContext& context, const gpu::Image& color, const gpu::Image& depth);
void drawDepth(const PassContext& context, const CameraDraws& draws);
void drawLit(const PassContext& context, const CameraDraws& draws);
void drawSky(const PassContext& context);
void drawBlended(const PassContext& context, const CameraDraws& draws);
void endCamera(const PassContext& context);

} // namespace halflight
