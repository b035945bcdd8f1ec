#pragma once
// What paths read, in a device's memory: of open gather rays, and whole ones.

#include "bake_gpu/gpu_surfaces.h"
#include "transport/radiosity/radiance_cache.h"

namespace halflight {

class PathTables {
public:
    /// For paths with up to `bounces` reflections. `cache`: where they may end; null = nowhere. Uploads the tables.
    /// Throws gpu::Failure. `surfaces` outlive it.
    PathTables(gpu::Device& device, const GpuScene& scene, const GpuSurfaces& surfaces, const PathTracer& paths,
               int bounces, const RadianceCache* cache);

    /// Of PathTables in shaders/bake/paths/tables.glsl.
    [[nodiscard]] VkDeviceAddress address() const { return tables_.address(); }

private:
    struct Addresses;
    template<typename List> VkDeviceAddress keep(gpu::Device& device, const List& list)
    {
        buffers_.push_back(bufferOf(device, std::span<const typename List::value_type>(list)));
        return buffers_.back().address();
    }
    void addSurfaces(gpu::Device& device, const RayTracer& surfaces, Addresses& to);
    void addFaces(gpu::Device& device, const GpuScene& scene, const PathTracer& paths, Addresses& to);
    void addPictures(gpu::Device& device, const Materials& materials, Addresses& to);
    void addLights(gpu::Device& device, const SceneLight& light, Addresses& to);
    void addLevels(gpu::Device& device, const RadianceCache& cache, int bounces, Addresses& to);

    std::vector<gpu::Buffer> buffers_; ///< what the tables point to
    gpu::Buffer tables_;
};

} // namespace halflight
