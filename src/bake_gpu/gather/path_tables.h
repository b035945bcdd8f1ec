#pragma once
// What paths read, in a device's memory: of open gather rays, and whole ones.

#include "bake_gpu/gather/gather_layout.h"
#include "bake_gpu/gpu_surfaces.h"
#include "transport/radiosity/radiance_cache.h"

#include <memory>

namespace halflight {

/// Tables in shaders/bake/gather.glsl.
struct GatherAddresses {
    VkDeviceAddress scene, pattern, radii, angles, surfaces, normals, elements, patches, guideOfPatch, sourcesOfGuide,
        guides, entries, cumulative, clusters, triangles, sourceMasks, bins, members, picture, paths;
    shading::GpuGatherConstants all;
};

class PathTables {
public:
    /// Uploads what all paths of the scene read. Throws gpu::Failure. All arguments outlive it.
    PathTables(gpu::Device& device, const GpuScene& scene, const GpuSurfaces& surfaces, const PathTracer& paths);
    ~PathTables();

    /// Of the tables in shaders/bake/gather.glsl what paths read: the scene, normals, the sky. The rest is zero.
    [[nodiscard]] const GatherAddresses& ofScene() const { return ofScene_; }
    /// PathTables of shaders/bake/paths/tables.glsl, for paths with up to `bounces` reflections. `cache`: where they
    /// may end; null = nowhere. It is uploaded to `buffers`. Throws gpu::Failure.
    [[nodiscard]] VkDeviceAddress forPaths(int bounces, const RadianceCache* cache,
                                           std::vector<gpu::Buffer>& buffers) const;

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
    void addSky(gpu::Device& device, const SkyLight& light);

    gpu::Device& device_;
    bool glossy_;                      ///< PathTracer::glossy()
    std::vector<gpu::Buffer> buffers_; ///< what the tables point to
    GatherAddresses ofScene_{};
    std::unique_ptr<Addresses> addresses_; ///< of what forPaths() does not set
};

} // namespace halflight
