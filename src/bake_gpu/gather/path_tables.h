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
        guides, entries, cumulative, clusters, triangles, sourceMasks, bins, members, picture, components, paths;
    shading::GpuGatherConstants all;
};

/// Push constants of shaders that trace, which read these tables.
struct TablesPush {
    VkDeviceAddress scene, tables, lists;
    uint32_t whole = 0; ///< of paths/paths.rgen: 1 = paths are whole; 0 = they go on from open rays
    uint32_t first = 0; ///< of these: number of the launch's first among all open rays
};

class PathTables {
public:
    /// Uploads what all paths of the scene read. Throws gpu::Failure. All arguments outlive it.
    PathTables(gpu::Device& device, const DeviceScene& scene, const GpuSurfaces& surfaces, const PathTracer& paths);
    ~PathTables();

    /// Of the tables in shaders/bake/gather.glsl what paths read: the scene, normals, the sky. The rest is zero.
    [[nodiscard]] const GatherAddresses& ofScene() const { return ofScene_; }
    /// PathTables of shaders/bake/paths/tables.glsl, for paths with up to `bounces` reflections. `cache`: where they
    /// may end; null = nowhere. It is uploaded to `buffers`. Throws gpu::Failure.
    [[nodiscard]] VkDeviceAddress forPaths(int bounces, const RadianceCache* cache,
                                           std::vector<gpu::Buffer>& buffers) const;

private:
    struct Addresses;
    template<typename List> VkDeviceAddress keep(const List& list)
    {
        buffers_.push_back(bufferOf(device_, std::span<const typename List::value_type>(list)));
        return buffers_.back().address();
    }
    void addSurfaces(const PathTracer& paths);
    void addFaces(const DeviceScene& scene, const PathTracer& paths);
    void addPictures(const Materials& materials);
    void addLights(const SceneLight& light);
    void addChoosers(const SceneLight& light);
    void addSky(const SkyLight& light);
    void addComponents(const SceneLight& light);

    gpu::Device& device_;
    bool glossy_;                      ///< PathTracer::glossy()
    std::vector<gpu::Buffer> buffers_; ///< what the tables point to
    GatherAddresses ofScene_{};
    std::unique_ptr<Addresses> addresses_; ///< of what forPaths() does not set
};

} // namespace halflight
