#include "bake_gpu/kernels.h"

#include "bake_gpu/gather/gather.h"
#include "bake_gpu/paths/paths.h"
#include "bake_gpu/radiosity/radiosity.h"
#include "bake_gpu/shadows/shadows.h"
#include "bake_gpu/shadows/validity.h"

#include <algorithm>
#include <cstring>

namespace halflight {
namespace {

/// Rays of one launch: 128 MiB of them.
constexpr std::size_t kMostOfLaunch = std::size_t(1) << 22;

static_assert(sizeof(Ray) == sizeof(shading::GpuRay) && sizeof(RayHit) == sizeof(shading::GpuHit));

/// Memory for a batch on both sides.
struct Batch {
    Batch(gpu::Device& device, std::size_t rays, std::size_t resultBytes)
        : upload(device, rays * sizeof(Ray), VK_BUFFER_USAGE_TRANSFER_SRC_BIT, gpu::MemoryUse::Upload),
          rays(device, rays * sizeof(Ray), gpu::kAddressed, gpu::MemoryUse::Device),
          results(device, rays * resultBytes, gpu::kAddressed, gpu::MemoryUse::Device),
          readback(device, rays * resultBytes, VK_BUFFER_USAGE_TRANSFER_DST_BIT, gpu::MemoryUse::Readback)
    {}
    gpu::Buffer upload, rays, results, readback;
};

/// What make() returns, or why the device cannot make it.
template<typename Interface, typename Make> Result<std::unique_ptr<Interface>> made(const Make& make)
{
    try {
        return std::unique_ptr<Interface>(make());
    } catch (const gpu::Failure& failure) {
        return Error{ErrorCode::DeviceFailed, failure.what()};
    }
}

} // namespace

GpuKernels::GpuKernels(std::shared_ptr<BakeDevice> device, const RayScene& scene, std::unique_ptr<RayKernels> cpu)
    : scene_(scene), device_(std::move(device)), cpu_(std::move(cpu)), deviceScene_(device_->device(), scene)
{
    if (scene.anyTinted()) device_->tinted(); // no driver compiles it while commands are recorded
}

/// Calls use(results, first) for each launch.
template<typename Out, typename Use>
Status GpuKernels::trace(Verb verb, std::span<const Ray> rays, bool byChance, const Use& use) const
{
    try {
        gpu::Device& device = device_->device();
        const std::size_t most = std::min(rays.size(), kMostOfLaunch);
        const Batch batch(device, most, sizeof(Out));
        for (std::size_t first = 0; first < rays.size(); first += most) {
            const auto some = rays.subspan(first, std::min(most, rays.size() - first));
            std::memcpy(batch.upload.mapped(), some.data(), some.size_bytes());
            const TracePush push{deviceScene_.address(), batch.rays.address(), batch.results.address(),
                                 byChance ? 1u : 0u, scene_.anyTinted()};
            device.execute([&](VkCommandBuffer commands) {
                gpu::copyBytes(device, commands, {batch.upload}, {batch.rays}, some.size_bytes());
                (device_.get()->*verb)(commands, push, uint32_t(some.size()));
                gpu::copyBytes(device, commands, {batch.results}, {batch.readback}, some.size() * sizeof(Out));
                gpu::fullBarrier(device, commands);
            });
            use(std::span(reinterpret_cast<const Out*>(batch.readback.mapped()), some.size()), first);
        }
    } catch (const gpu::Failure& failure) {
        return Error{ErrorCode::DeviceFailed, failure.what()};
    }
    return {};
}

Status GpuKernels::nearest(std::span<const Ray> rays, std::span<RayHit> out, RayUse use) const
{
    if (!onDevice(rays.size()) || use == RayUse::Camera) return cpu_->nearest(rays, out, use);
    return trace<RayHit>(&BakeDevice::nearest, rays, false, [&](std::span<const RayHit> hits, std::size_t first) {
        std::copy(hits.begin(), hits.end(), out.begin() + std::ptrdiff_t(first));
    });
}

Status GpuKernels::occluded(std::span<const Ray> rays, std::span<bool> out) const
{
    if (!onDevice(rays.size())) return cpu_->occluded(rays, out);
    return trace<float>(&BakeDevice::transmittance, rays, true, [&](std::span<const float> passed, std::size_t first) {
        for (std::size_t i = 0; i < passed.size(); ++i) out[first + i] = passed[i] == 0.0f;
    });
}

Status GpuKernels::transmittance(std::span<const Ray> rays, std::span<vec3> out) const
{
    if (!onDevice(rays.size())) return cpu_->transmittance(rays, out);
    if (scene_.anyTinted())
        return trace<vec3>(&BakeDevice::transmittance, rays, false,
                           [&](std::span<const vec3> passed, std::size_t first) {
                               std::copy(passed.begin(), passed.end(), out.begin() + std::ptrdiff_t(first));
                           });
    return trace<float>(&BakeDevice::transmittance, rays, false, [&](std::span<const float> passed, std::size_t first) {
        for (std::size_t i = 0; i < passed.size(); ++i) out[first + i] = vec3(passed[i]);
    });
}

Status GpuKernels::crossings(std::span<const Ray> rays, std::span<int> out) const
{
    if (!onDevice(rays.size())) return cpu_->crossings(rays, out);
    return trace<int>(&BakeDevice::crossings, rays, false, [&](std::span<const int> left, std::size_t first) {
        std::copy(left.begin(), left.end(), out.begin() + std::ptrdiff_t(first));
    });
}

const GpuSurfaces& GpuKernels::surfaces() const
{
    const std::lock_guard lock(laterMutex_);
    if (!surfaces_) surfaces_.emplace(device_->device(), deviceScene_, scene_.geometry());
    return *surfaces_;
}

/// `paths` is the one that has these kernels.
const PathTables& GpuKernels::pathTables(const PathTracer& paths) const
{
    const GpuSurfaces& places = surfaces();
    const std::lock_guard lock(laterMutex_);
    if (!pathTables_) pathTables_.emplace(device_->device(), deviceScene_, places, paths);
    return *pathTables_;
}

Result<std::unique_ptr<DeviceGather>> GpuKernels::prepareGather(const GatherTables& tables) const
{
    return made<DeviceGather>(
        [&] { return std::make_unique<GpuGather>(*device_, deviceScene_, pathTables(tables.paths), tables); });
}

Result<std::unique_ptr<DevicePaths>> GpuKernels::preparePaths(const PathTracer& paths, int bounces) const
{
    return made<DevicePaths>(
        [&] { return std::make_unique<GpuPaths>(*device_, deviceScene_, pathTables(paths), paths, bounces); });
}

Result<std::unique_ptr<DeviceRadiosity>> GpuKernels::prepareRadiosity(const RadiosityInput& input,
                                                                      const PatchLayout& layout) const
{
    return made<DeviceRadiosity>(
        [&] { return std::make_unique<GpuRadiosity>(*device_, deviceScene_, pathTables(input.paths), input, layout); });
}

Result<std::unique_ptr<DeviceShadows>> GpuKernels::prepareShadows(const ShadowTables& tables) const
{
    const bool any = std::any_of(tables.lights.begin(), tables.lights.end(),
                                 [](const PunctualLight& light) { return light.channel >= 0 || light.directAtTexels; });
    if (!any) return std::unique_ptr<DeviceShadows>();
    return made<DeviceShadows>(
        [&] { return std::make_unique<GpuShadows>(*device_, deviceScene_, surfaces(), tables); });
}

Result<std::unique_ptr<DeviceValidity>> GpuKernels::prepareValidity() const
{
    const std::vector<uint8_t>& solid = scene_.geometry().solid;
    const bool anySolid = std::find(solid.begin(), solid.end(), uint8_t(1)) != solid.end();
    return made<DeviceValidity>([&] { return std::make_unique<GpuValidity>(*device_, deviceScene_, anySolid); });
}

std::string GpuKernels::describe(const std::string& method) const
{
    return "gpu (" + method + ", " + halflight::describe(*device_) + "), " + cpu_->describe("the rest");
}

} // namespace halflight
