#include "bake_gpu/gpu_surfaces.h"

#include "bake_gpu/transfer.h"

#include <type_traits>

namespace halflight {
namespace {

using shading::GpuInstance;

static_assert(sizeof(BakeGeometry::Frame) == sizeof(shading::GpuTriangleFrame));

/// SurfaceData in shaders/bake/texels.glsl.
struct SurfaceAddresses {
    VkDeviceAddress corners, frames, positions, normals, places, instances;
};

GpuInstance gpuInstance(const BakeGeometry::Instance& from)
{
    GpuInstance to{};
    for (int column = 0; column < 3; ++column) {
        to.linear[column] = from.linear[column];
        to.worldFromNormal[column] = from.worldFromNormal[column];
    }
    to.origin = from.origin;
    to.texelScale = from.texelScale;
    to.texelOffset = from.texelOffset;
    to.mirrored = from.mirrored ? 1u : 0u;
    return to;
}

} // namespace

template<typename T, typename Make>
VkDeviceAddress GpuSurfaces::upload(gpu::Device& device, std::size_t count, const Make& make)
{
    buffers_.emplace_back(device, count * sizeof(T), gpu::kAddressed, gpu::MemoryUse::Device);
    Transfer(device).upload<T>(buffers_.back(), count, make);
    return buffers_.back().address();
}

GpuSurfaces::GpuSurfaces(gpu::Device& device, const DeviceScene& scene, const BakeGeometry& geometry)
{
    const auto copy = [&](const auto& list) {
        using T = typename std::decay_t<decltype(list)>::value_type;
        return upload<T>(device, list.size(), [&](std::size_t i) { return list[i]; });
    };
    SurfaceAddresses a{};
    a.corners = copy(geometry.triangles);
    a.frames = copy(geometry.frames);
    a.positions = scene.positions();
    a.normals = copy(geometry.normals);
    a.places = copy(geometry.lightmapTexel);
    a.instances = upload<GpuInstance>(device, geometry.instances.size(),
                                      [&](std::size_t i) { return gpuInstance(geometry.instances[i]); });
    addresses_ = bufferOf(device, std::span<const SurfaceAddresses>(&a, 1));
}

} // namespace halflight
