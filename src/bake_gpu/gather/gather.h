#pragma once
// The final gather on a device: rays, lookups, paths and sums of a batch of blocks, in two submissions.

#include "bake_gpu/gather/path_tables.h"
#include "bake_gpu/texel_lists.h"
#include "transport/lightmap/device_gather.h"

#include <mutex>

namespace halflight {

class GpuGather final : public DeviceGather {
public:
    /// Uploads the tables. Throws gpu::Failure. All but `tables` outlive it.
    GpuGather(BakeDevice& device, const DeviceScene& scene, const PathTables& pathTables, const GatherTables& tables);
    ~GpuGather() override;

    Status gather(const TexelMap& map, const Batch& batch, const Light& out, uint64_t& rays) const override;

private:
    struct Workspace;
    void setLists(const TexelLists::Copy& mapTexels, const Batch& batch) const;
    uint32_t placesOfOpenRays(std::size_t blocks) const;
    void traceRays(std::size_t texels, std::size_t blocks) const;
    void finishRays(std::size_t texels, std::size_t blocks, uint32_t open) const;
    [[nodiscard]] TracePush sourcePush() const;
    void tracePaths(VkCommandBuffer commands, std::size_t blocks, uint32_t open) const;
    void copyComponents(VkCommandBuffer commands, std::size_t blocks) const;
    void sampleEmitters(VkCommandBuffer commands, std::size_t texels, std::size_t blocks) const;

    BakeDevice& device_;
    const DeviceScene& scene_;
    const gpu::RayPipeline& paths_;
    const EmitterPipelines* emitters_;     ///< null: the scene has neither emitters nor a bright part of the sky
    const ComponentPipelines* components_; ///< null: light is estimated as one
    std::size_t componentCount_;
    bool anyEmitters_;
    bool anySources_ = false;          ///< some guide samples secondary sources
    std::vector<gpu::Buffer> buffers_; ///< what the tables point to
    gpu::Buffer tables_;
    mutable std::mutex mutex_; ///< the workspace takes turns
    std::unique_ptr<Workspace> workspace_;
};

} // namespace halflight
