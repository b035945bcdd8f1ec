#pragma once
// Whole paths on a device: those of path-traced lightmaps and of probes.

#include "bake_gpu/gather/path_tables.h"
#include "transport/trace/device_paths.h"

#include <condition_variable>
#include <mutex>

namespace halflight {

class GpuPaths final : public DevicePaths {
public:
    /// Uploads the tables. Throws gpu::Failure. All arguments outlive it.
    GpuPaths(BakeDevice& device, const DeviceScene& scene, const PathTables& pathTables, const PathTracer& paths,
             int bounces);
    ~GpuPaths() override;

    Status trace(const Batch& batch, Use use) const override;

private:
    struct Workspace;
    class Turn;
    void run(const Workspace& workspace, const Batch& batch) const;

    BakeDevice& device_;
    const DeviceScene& scene_;
    const gpu::RayPipeline& pipeline_;
    bool samplesEmission_;             ///< SceneLight::samplesEmission()
    int components_;                   ///< SceneLight::components()
    std::vector<gpu::Buffer> buffers_; ///< what the tables point to
    gpu::Buffer tables_;
    mutable std::mutex mutex_;                                   ///< guards what follows
    mutable std::vector<std::unique_ptr<Workspace>> workspaces_; ///< as many as were needed at one time so far
    mutable std::vector<Workspace*> free_;                       ///< workspaces that no call has
    mutable std::condition_variable freed_;                      ///< of a workspace
};

} // namespace halflight
