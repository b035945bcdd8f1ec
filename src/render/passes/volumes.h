#pragma once
// Closed volumes of glass (spec S35): what is behind them takes their colour, for the way that each pixel's ray goes
// through them.

#include "render/passes/passes.h"

namespace halflight {

/// Optical depths of a frame, and the pipelines that make and apply them. Made with the first frame that has volumes.
struct VolumePasses {
    VolumePasses(const gpu::Device& device, VkPipelineLayout layout, VkFormat colorFormat);
    /// An image of that size; frames in flight may still use the one before.
    void ensure(const gpu::Device& device, ivec2 size);

    VkFormat format; ///< full floats; half floats where the device cannot blend those
    gpu::Image depths;
    gpu::UniquePipeline add;
    gpu::UniquePipeline absorb;
};

/// Optical depths by the faces of `draws`, and the picture times what they leave. `depth` is that of all solid parts;
/// both images are in the states of attachments before and after, outside of rendering.
void drawVolumes(const PassContext& context, const VolumePasses& passes, const gpu::Image& color,
                 const gpu::Image& depth, const CameraDraws& draws);

} // namespace halflight
