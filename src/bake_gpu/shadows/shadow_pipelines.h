#pragma once
// The compute shaders around shadow rays.

#include "gpu/compute.h"

#include <vector>

namespace halflight {

struct ShadowPipelines {
    /// Throws gpu::Failure.
    explicit ShadowPipelines(const gpu::Device& device);

    gpu::ComputePipeline lifts;
    gpu::ComputePipeline rays;
    gpu::ComputePipeline sums;

    /// Their code.
    static std::vector<std::span<const uint32_t>> shaders();
};

} // namespace halflight
