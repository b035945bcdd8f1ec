#pragma once
// The triangles that texels lie on, in a device's memory.

#include "bake_gpu/device_scene.h"

#include "halflight/bake/integrator.h"

#include <vector>

namespace halflight {

class GpuSurfaces {
public:
    /// Throws gpu::Failure. All arguments outlive it.
    GpuSurfaces(gpu::Device& device, const DeviceScene& scene, const BakeGeometry& geometry);

    /// Of the block of addresses that shaders read (SurfaceData in shaders/bake/texels.glsl).
    [[nodiscard]] VkDeviceAddress address() const { return addresses_.address(); }

private:
    template<typename T, typename Make>
    VkDeviceAddress upload(gpu::Device& device, std::size_t count, const Make& make);

    std::vector<gpu::Buffer> buffers_;
    gpu::Buffer addresses_;
};

} // namespace halflight
