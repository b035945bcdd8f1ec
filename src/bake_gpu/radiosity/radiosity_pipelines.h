#pragma once
// The shaders of the radiosity passes.

#include "gpu/compute.h"

#include <span>
#include <vector>

namespace halflight {

struct RadiosityPipelines {
    /// Throws gpu::Failure.
    explicit RadiosityPipelines(gpu::Device& device);

    gpu::ComputePipeline points;
    gpu::RayPipeline occluders;
    gpu::RayPipeline factors;
    gpu::RayPipeline direct;

    /// Their code, but for shaders of hits.
    static std::vector<std::span<const uint32_t>> shaders();
};

} // namespace halflight
