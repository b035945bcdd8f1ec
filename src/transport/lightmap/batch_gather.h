#pragma once
// Feeds a DeviceGather with texels.

#include "transport/lightmap/block_sums.h"
#include "transport/lightmap/device_gather.h"

#include <atomic>
#include <functional>

namespace halflight {

class BatchGather {
public:
    BatchGather(const DeviceGather& device, const TexelMap& map, const SceneLight& light)
        : device_(device), map_(map), samplesEmission_(light.samplesEmission()),
          components_(std::size_t(light.components()))
    {}

    /// Adds blocks `firstBlock` … `firstBlock` + blocks - 1 to the estimate of a texel.
    struct Request {
        uint32_t texel = 0;
        int blocks = 0;
        TexelEstimate* estimate = nullptr;
        std::span<ComponentEstimate> components; ///< of the texel, one after another
    };
    /// On all threads. `rays` are counted.
    Status add(std::span<const Request> requests, int firstBlock, const Progress& progress,
               std::atomic<uint64_t>& rays) const;

private:
    struct Batch;
    void prepare(Batch& batch) const;
    Status gather(Batch& batch, uint64_t& rays) const;
    void add(const Batch& batch, std::size_t number) const;

    const DeviceGather& device_;
    const TexelMap& map_;
    bool samplesEmission_; ///< SceneLight::samplesEmission()
    std::size_t components_;
};

} // namespace halflight
