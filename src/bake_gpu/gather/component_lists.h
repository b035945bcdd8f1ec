#pragma once
// The light of components in a call of the final gather, in a device's memory.

#include "bake_gpu/bake_device.h"
#include "bake_gpu/gather/gather_layout.h"
#include "transport/lightmap/device_gather.h"

namespace halflight {

/// What a call has of components; empty where light is estimated as one.
struct ComponentLists {
    ComponentLists() = default;
    ComponentLists(gpu::Device& device, const SceneLight& light)
    {
        using Halves = DeviceGather::Halves;
        const auto count = std::size_t(light.components());
        if (count == 0) return;
        const std::size_t blocks = DeviceGather::mostBlocks(count);
        const std::size_t rays = blocks * shading::kPatternBlock;
        const auto make = [&](std::size_t bytes, gpu::MemoryUse use = gpu::MemoryUse::Device) {
            return gpu::Buffer(device, bytes, gpu::kAddressed, use);
        };
        mostPaths = std::min(kMostPathBytes / (count * sizeof(vec3)), rays);
        before = make(blocks * count * sizeof(vec3), gpu::MemoryUse::Upload);
        rayLights = make(rays * sizeof(shading::GpuRayLight));
        sourceLights = make(rays * sizeof(shading::GpuRayLight));
        if (!light.emitters().empty()) emitterHits = make(rays * sizeof(shading::GpuEmitterHit));
        pathLights = make(mostPaths * count * sizeof(vec3));
        sums = make(blocks * count * sizeof(Halves));
        sumsRead = make(blocks * count * sizeof(Halves), gpu::MemoryUse::Readback);
        if (!light.samplesEmission()) return;
        emitted = make(blocks * count * sizeof(Halves));
        emittedRead = make(blocks * count * sizeof(Halves), gpu::MemoryUse::Readback);
    }

    /// Of the light of paths that one launch traces.
    static constexpr std::size_t kMostPathBytes = std::size_t(32) << 20;
    std::size_t mostPaths = DeviceGather::kMostBlocks * shading::kPatternBlock; ///< of a launch
    gpu::Buffer before, rayLights, sourceLights, emitterHits, pathLights, sums, sumsRead, emitted, emittedRead;
};

} // namespace halflight
