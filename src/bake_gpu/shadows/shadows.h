#pragma once
// Shadow rays on a device: their origins, both rays of each and their sums, in one submission.

#include "bake_gpu/gpu_surfaces.h"
#include "bake_gpu/texel_lists.h"
#include "transport/shadows/device_shadows.h"

#include <memory>
#include <mutex>

namespace halflight {

class GpuShadows final : public DeviceShadows {
public:
    /// Uploads the tables. Throws gpu::Failure. All but the tables outlive it.
    GpuShadows(BakeDevice& device, const DeviceScene& scene, const GpuSurfaces& surfaces, const ShadowTables& tables);
    ~GpuShadows() override;

    Status trace(const TexelMap& map, const Batch& batch, std::span<LitSum> sums, std::span<vec3> colors,
                 uint64_t& rays) const override;

private:
    struct Workspace;
    void setSources(std::span<const ShadowSource> sources) const;
    void setItems(std::span<const Item> items, uint32_t firstTexel) const;
    uint32_t traceItems(std::size_t itemCount) const;

    BakeDevice& device_;
    const DeviceScene& scene_;
    const BakeGeometry& geometry_;
    const PunctualLight* firstLight_;  ///< of the scene
    bool anySmooth_ = false;           ///< some triangle's normals describe a curved surface
    std::vector<gpu::Buffer> buffers_; ///< what the tables point to
    gpu::Buffer tables_;
    mutable std::mutex mutex_; ///< the workspace takes turns
    std::unique_ptr<Workspace> workspace_;
};

} // namespace halflight
