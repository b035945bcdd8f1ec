#pragma once
// A scene's triangles, trees and masks on a device.

#include "bake_gpu/bake_device.h"
#include "bake_gpu/layout.h"
#include "transport/trace/ray_scene.h"

namespace halflight {

class DeviceScene {
public:
    /// Uploads the scene and builds its trees. Throws gpu::Failure. `device` outlives it.
    DeviceScene(gpu::Device& device, const RayScene& scene);

    /// Of the block of addresses that shaders read (SceneData in shaders/bake/scene.glsl).
    [[nodiscard]] VkDeviceAddress address() const { return addresses_.address(); }
    /// Of the positions of BakeGeometry.
    [[nodiscard]] VkDeviceAddress positions() const { return positions_.address(); }
    /// Number of a hit triangle among the masked ones; shading::kNone of opaque ones.
    [[nodiscard]] uint32_t maskedOf(uint32_t hitIndex) const;
    /// RayScene::anyTinted().
    [[nodiscard]] bool tinted() const { return tinted_; }
    /// Bytes on the device.
    [[nodiscard]] std::size_t bytes() const;

private:
    std::vector<shading::GpuSlot> places_; ///< in ascending order of hit indices
    gpu::Buffer positions_;
    std::vector<gpu::Tree> meshes_;
    gpu::Tree tree_;
    gpu::Buffer slots_;
    gpu::Buffer faces_;
    gpu::Buffer masked_;
    gpu::Buffer masks_;
    gpu::Buffer pictures_;
    gpu::Buffer texels_;
    gpu::Buffer glass_, glassNumbers_, glassTriangles_, linear_; ///< empty where no glass has a colour
    gpu::Buffer addresses_;
    bool tinted_;
};

} // namespace halflight
