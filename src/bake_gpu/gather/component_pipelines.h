#pragma once
// The compute shaders that add up the light of components in the final gather.

#include "gpu/compute.h"

#include <span>
#include <vector>

namespace halflight {

struct ComponentPipelines {
    /// Throws gpu::Failure.
    explicit ComponentPipelines(const gpu::Device& device);

    gpu::ComputePipeline gathered;
    gpu::ComputePipeline paths;
    gpu::ComputePipeline emitted;

    /// Their code.
    static std::vector<std::span<const uint32_t>> shaders();
};

/// Push constants of shaders/bake/gather.glsl; of `paths` with the numbers of a launch's open rays.
struct GatherPush {
    VkDeviceAddress tables, lists;
};
struct OpenRangePush {
    VkDeviceAddress tables, lists;
    uint32_t first, end;
};

} // namespace halflight
