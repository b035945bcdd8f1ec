#pragma once
// The sky's picture on the GPU.

#include "gpu/resources.h"

#include "halflight/scene/scene.h"

namespace halflight {

/// The picture with mip levels that are means by solid angle; one black texel without a picture.
struct SkyTexture {
    gpu::Image image;
    gpu::UniqueSampler sampler;
    float unitNits = 1.0f; ///< of a texel's value 1
};
SkyTexture uploadSky(gpu::Device& device, gpu::Uploader& uploader, const Sky& sky);

/// GpuFrame::skyPicture.
vec4 skyPictureOfFrame(const SkyTexture& texture, const Sky& sky);

} // namespace halflight
