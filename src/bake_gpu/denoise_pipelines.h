#pragma once
// The denoiser's compute shaders.

#include "gpu/compute.h"

namespace halflight {

struct DenoisePipelines {
    /// Throws gpu::Failure.
    explicit DenoisePipelines(const gpu::Device& device);

    gpu::ComputePipeline differences;
    gpu::ComputePipeline variances;
    gpu::ComputePipeline outliers;
    gpu::ComputePipeline filter;
};

} // namespace halflight
