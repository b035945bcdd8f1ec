#pragma once
// The compute shaders that sample emitters and the sky's bright part in the final gather.

#include "gpu/compute.h"

#include <vector>

namespace halflight {

struct EmitterPipelines {
    /// Throws gpu::Failure.
    explicit EmitterPipelines(const gpu::Device& device);

    gpu::ComputePipeline cuts;
    gpu::ComputePipeline hits;
    gpu::ComputePipeline shares;
    gpu::ComputePipeline rays;
    gpu::ComputePipeline sums;

    /// Their code.
    static std::vector<std::span<const uint32_t>> shaders();
};

} // namespace halflight
