#pragma once
// The passes of a frame: each records its commands and nothing else.

#include "halflight/render/renderer.h"
#include "render/scene/draw_list.h"

#include <array>
#include <optional>
#include <span>
#include <vector>

namespace halflight {

constexpr VkFormat kDepthFormat = VK_FORMAT_D32_SFLOAT;

/// One pipeline per pass and kind of surface.
struct Pipelines {
    Pipelines(const gpu::Device& device, VkDescriptorSetLayout set, VkFormat colorFormat);

    gpu::UniquePipelineLayout layout;
    gpu::UniquePipeline shadow;
    gpu::UniquePipeline shadowMasked;
    gpu::UniquePipeline shadowBlended;
    gpu::UniquePipeline depth;
    gpu::UniquePipeline depthMasked;
    gpu::UniquePipeline sky;
};

/// The numbers of mask layers that shaders are made for: 0, 1, 2 and 4.
constexpr int shaderMaskLayers(int layers)
{
    return layers == 3 ? 4 : layers;
}

/// What shaders read of masks, for which they are made (spec S11, S35, S36).
struct MaskUse {
    int layers = 0;       ///< of shaderMaskLayers()
    bool colored = false; ///< some mask has a colour

    static constexpr int kCount = 2 * (kMostMaskLayers + 1);
    [[nodiscard]] int number() const { return 2 * layers + int(colored); } ///< below kCount
};

/// Surfaces that are lit as they are drawn.
struct ForwardPipelines {
    ForwardPipelines(const gpu::Device& device, VkPipelineLayout layout, VkFormat colorFormat, MaskUse masks);
    /// Before frames that draw these blended parts: a CPU driver compiles a pipeline for a second.
    void ensureBlend(const gpu::Device& device, VkPipelineLayout layout, VkFormat colorFormat, MaskUse masks,
                     std::span<const Draw> blended);

    gpu::UniquePipeline lit;
    gpu::UniquePipeline blend;
    gpu::UniquePipeline pass; ///< of coloured glass: what it lets through
    gpu::UniquePipeline add;  ///< and its own light
};

/// What the deferred path draws into besides the picture: see shaders/gbuffer.glsl.
struct GBuffer {
    gpu::Image baseColor;
    gpu::Image normals;
    gpu::Image material;
    gpu::Image mask;        ///< none unless a mask is in use (spec S26); of one mask layer, or of two
    gpu::Image furtherMask; ///< of the third and the fourth layer

    /// Images of that size; frames in flight may still use the ones before.
    void ensure(const gpu::Device& device, ivec2 size, int maskLayers);
    [[nodiscard]] std::vector<const gpu::Image*> images() const;
};

/// The deferred path's own pipelines, for a G-buffer of so many mask layers.
struct DeferredPipelines {
    /// Throws gpu::Failure on a device that cannot draw into so many targets at once.
    DeferredPipelines(const gpu::Device& device, VkPipelineLayout layout, VkFormat colorFormat, MaskUse masks);

    gpu::UniquePipeline gBuffer;
    gpu::UniquePipeline light;
};

/// What every pass needs to record.
struct PassContext {
    const gpu::Device& device;
    const GpuScene& scene;
    const Pipelines& pipelines;
    VkDescriptorSet set;
    VkCommandBuffer commands;
    PassReport& counts; ///< of the pass being recorded: every draw call is added to it
};

void bindScene(const PassContext& context);

/// Begins drawing into a rectangle; viewport and scissor are set to it.
void beginRendering(const PassContext& context, std::span<const VkRenderingAttachmentInfo> colors,
                    const std::optional<VkRenderingAttachmentInfo>& depth, ivec2 size, ivec2 offset = ivec2(0));
void endRendering(const PassContext& context);
void setScissor(const PassContext& context, ivec2 offset, ivec2 size);
/// One triangle over all of the viewport.
void drawWholePicture(const PassContext& context, VkPipeline pipeline);

/// A shadow tile as a rectangle of a depth image.
struct ShadowDraws {
    mat4 clipFromWorld{1.0f};
    ivec2 offset{0};
    int size = 0;
    float slopeBias = 0.0f; ///< Vulkan's depthBiasSlopeFactor
    std::vector<Draw> draws;
};
/// Clears a rectangle of one layer to "lit"; tiles are drawn into it until endRendering().
void beginShadowLayer(const PassContext& context, VkImageView layer, ivec2 low, ivec2 high);
void drawShadowTiles(const PassContext& context, std::span<const ShadowDraws> tiles);

/// What the camera sees. Each solid part is in one of two lists.
struct CameraDraws {
    mat4 clipFromWorld{1.0f};
    std::vector<Draw> deferred; ///< drawn into the G-buffer
    std::vector<Draw> forward;  ///< lit as they are drawn
    std::vector<Draw> volumes;  ///< of the blended parts closed glass with a volume
    std::vector<Draw> blended;
};
/// Depth of all solid parts: later passes draw where depth is equal.
void drawDepth(const PassContext& context, const gpu::Image& depth, const CameraDraws& draws);

/// All faces of parts, without a depth test, into an image that is cleared before.
void drawAllFaces(const PassContext& context, VkPipeline pipeline, const gpu::Image& color, const mat4& clipFromWorld,
                  std::span<const Draw> draws);
/// One triangle over a whole image.
void drawOverPicture(const PassContext& context, VkPipeline pipeline, const gpu::Image& color);

/// The deferred path: surfaces with emissive and indirect light; direct light for all of them comes after.
void drawGBuffer(const PassContext& context, const DeferredPipelines& pipelines, const GBuffer& gBuffer,
                 const gpu::Image& color, const gpu::Image& depth, const CameraDraws& draws);

/// The forward passes, within one rendering scope: lit surfaces, sky, blended surfaces.
void beginForward(const PassContext& context, const gpu::Image& color, const gpu::Image& depth,
                  VkAttachmentLoadOp loadColor);
void drawLit(const PassContext& context, const ForwardPipelines& pipelines, const CameraDraws& draws);
void drawSky(const PassContext& context);
void drawBlended(const PassContext& context, const ForwardPipelines& pipelines, const CameraDraws& draws);

} // namespace halflight
