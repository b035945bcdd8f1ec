#pragma once
// What the paths of open gather rays read, in a device's memory.

#include "bake_gpu/gpu_surfaces.h"
#include "transport/lightmap/device_gather.h"

namespace halflight {

class PathTables {
public:
    /// Uploads the tables. Throws gpu::Failure. `surfaces` outlive it.
    PathTables(gpu::Device& device, const GpuScene& scene, const GpuSurfaces& surfaces, const GatherTables& tables);

    /// Of PathTables in shaders/bake/paths/tables.glsl.
    [[nodiscard]] VkDeviceAddress address() const { return tables_.address(); }

private:
    struct Addresses;
    template<typename List> VkDeviceAddress keep(gpu::Device& device, const List& list)
    {
        buffers_.push_back(bufferOf(device, std::span<const typename List::value_type>(list)));
        return buffers_.back().address();
    }
    void addSurfaces(gpu::Device& device, const GatherTables& tables, Addresses& to);
    void addPictures(gpu::Device& device, const Materials& materials, Addresses& to);
    void addLights(gpu::Device& device, const GpuScene& scene, const GatherTables& tables, Addresses& to);

    std::vector<gpu::Buffer> buffers_; ///< what the tables point to
    gpu::Buffer tables_;
};

} // namespace halflight
