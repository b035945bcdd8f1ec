#pragma once
// The shaders of the radiosity passes.

#include "gpu/compute.h"

#include <span>
#include <vector>

namespace halflight {

struct RadiosityPipelines {
    /// `tinted`: of scenes whose glass has a colour. Throws gpu::Failure.
    RadiosityPipelines(gpu::Device& device, bool tinted);

    gpu::ComputePipeline points;
    gpu::RayPipeline occluders;
    gpu::RayPipeline factors;
    gpu::RayPipeline direct;

    /// Their code, but for shaders of hits.
    static std::vector<std::span<const uint32_t>> shaders();
};

} // namespace halflight
