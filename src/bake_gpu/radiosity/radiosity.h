#pragma once
// The rays of the radiosity passes on a device: each is made, traced and used by one invocation.

#include "bake_gpu/gather/path_tables.h"
#include "bake_gpu/radiosity/radiosity_layout.h"
#include "bake_gpu/texel_lists.h"
#include "bake_gpu/transfer.h"
#include "transport/radiosity/device_radiosity.h"

#include <memory>

namespace halflight {

struct RadiosityPipelines;

class GpuRadiosity final : public DeviceRadiosity {
public:
    /// Uploads the tables. Throws gpu::Failure. All arguments outlive it, the layout until its last call.
    GpuRadiosity(BakeDevice& device, const DeviceScene& scene, const PathTables& pathTables,
                 const RadiosityInput& input, const PatchLayout& layout);
    ~GpuRadiosity() override;

    Status begin(const PatchPass& pass) override;
    Status findOccluded(std::span<const uint32_t> items, std::vector<PatchId>& found, uint64_t& rays) override;
    Status gather(std::span<const uint32_t> items, Traced& traced, uint64_t& rays) override;
    [[nodiscard]] std::size_t mostItems() const override;

private:
    struct Workspace;
    /// Buffers of a pass.
    struct PassBuffers {
        gpu::Buffer states, elements;
        gpu::Buffer tally;   ///< number of rays; then a bit for each patch and element that an occluder crosses
        gpu::Buffer noTally; ///< zeros
        gpu::Buffer tallied; ///< a copy of `tally` that the processor reads
    };
    void setPass(const PatchPass& pass);
    void setItems(std::span<const uint32_t> items);
    /// Views of the buffers that the call for so many items copies its results to.
    [[nodiscard]] Traced tracedOf(std::size_t items) const;
    template<typename Launch, typename Copy> void run(std::size_t items, const Launch& launch, const Copy& copy);
    [[nodiscard]] std::span<const uint32_t> tallied() const;

    BakeDevice& device_;
    const DeviceScene& scene_;
    const RadiosityInput& input_;
    const RadiosityPipelines& pipelines_;
    std::vector<gpu::Buffer> buffers_; ///< what the tables point to
    gpu::Buffer tables_;
    VkDeviceAddress widths_ = 0;
    Transfer transfer_;
    const PatchPass* pass_ = nullptr; ///< of begin()
    shading::GpuRadiosityPass constants_{};
    PassBuffers passBuffers_;
    std::unique_ptr<Workspace> workspace_;
};

} // namespace halflight
