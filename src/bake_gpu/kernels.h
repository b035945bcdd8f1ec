#pragma once
// Vulkan's ray-tracing pipelines behind RayKernels.

#include "bake_gpu/gather/path_tables.h"
#include "transport/trace/ray_kernels.h"

#include <mutex>
#include <optional>

namespace halflight {

/// Large batches are traced on the device, small ones on the processor, and so are the rays of cameras.
class GpuKernels final : public RayKernels {
public:
    /// Throws gpu::Failure. `cpu`: kernels of the same scene.
    GpuKernels(std::shared_ptr<BakeDevice> device, const RayScene& scene, std::unique_ptr<RayKernels> cpu);

    Status nearest(std::span<const Ray> rays, std::span<RayHit> out, RayUse use) const override;
    Status occluded(std::span<const Ray> rays, std::span<bool> out) const override;
    Status transmittance(std::span<const Ray> rays, std::span<vec3> out) const override;
    Status crossings(std::span<const Ray> rays, std::span<int> out) const override;
    bool trianglesNear(vec3 center, float radius, std::size_t most, std::vector<uint32_t>& triangles) const override
    {
        return cpu_->trianglesNear(center, radius, most, triangles);
    }
    [[nodiscard]] Result<std::unique_ptr<DeviceGather>> prepareGather(const GatherTables& tables) const override;
    [[nodiscard]] Result<std::unique_ptr<DevicePaths>> preparePaths(const PathTracer& paths,
                                                                    int bounces) const override;
    [[nodiscard]] Result<std::unique_ptr<DeviceRadiosity>> prepareRadiosity(const RadiosityInput& input,
                                                                            const PatchLayout& layout) const override;
    [[nodiscard]] Result<std::unique_ptr<DeviceShadows>> prepareShadows(const ShadowTables& tables) const override;
    [[nodiscard]] Result<std::unique_ptr<DeviceValidity>> prepareValidity() const override;
    [[nodiscard]] std::string describe(const std::string& method) const override;
    [[nodiscard]] std::size_t peakBytes() const override { return cpu_->peakBytes(); }

    /// Rays from which on a batch goes to the device: below, the way there takes longer than the processor.
    static constexpr std::size_t kLeastBatch = 4096;

private:
    using Verb = void (BakeDevice::*)(VkCommandBuffer, const TracePush&, uint32_t);
    template<typename Out, typename Use>
    Status trace(Verb verb, std::span<const Ray> rays, bool byChance, const Use& use) const;
    [[nodiscard]] bool onDevice(std::size_t rays) const { return rays >= kLeastBatch; }

    /// Made when they are first asked for. Throws gpu::Failure.
    const GpuSurfaces& surfaces() const;
    const PathTables& pathTables(const PathTracer& paths) const;

    const RayScene& scene_;
    std::shared_ptr<BakeDevice> device_;
    std::unique_ptr<RayKernels> cpu_;
    DeviceScene deviceScene_;
    mutable std::mutex laterMutex_; ///< guards what follows
    mutable std::optional<GpuSurfaces> surfaces_;
    mutable std::optional<PathTables> pathTables_;
};

} // namespace halflight
