#pragma once
// Feeds a DeviceGather with texels, and finishes what it leaves open.

#include "transport/lightmap/device_gather.h"
#include "transport/lightmap/final_gather.h"

#include <atomic>
#include <functional>

namespace halflight {

class BatchGather {
public:
    BatchGather(const DeviceGather& device, const PathTracer& paths, const StratifiedPattern& pattern,
                const RadianceCache& cache, const Guides& guides, const IntegrationSettings& settings,
                const TexelMap& map)
        : device_(device), paths_(paths), pattern_(pattern), cache_(cache), guides_(guides), settings_(settings),
          map_(map)
    {}

    /// Adds blocks `firstBlock` … `firstBlock` + blocks - 1 to the estimate of a texel.
    struct Request {
        uint32_t texel = 0;
        int blocks = 0;
        TexelEstimate* estimate = nullptr;
    };
    /// On all threads. `rays` are counted.
    Status add(std::span<const Request> requests, int firstBlock, const Progress& progress,
               std::atomic<uint64_t>& rays) const;

private:
    struct Batch;
    void prepare(Batch& batch) const;
    void finish(const Batch& batch, std::span<const DeviceGather::Sums> sums,
                std::span<const DeviceGather::EmitterHit> emissive, std::atomic<uint64_t>& rays) const;
    [[nodiscard]] FinalGather makeGather() const { return {paths_, pattern_, &cache_, &guides_, settings_}; }

    const DeviceGather& device_;
    const PathTracer& paths_;
    const StratifiedPattern& pattern_;
    const RadianceCache& cache_;
    const Guides& guides_;
    const IntegrationSettings& settings_;
    const TexelMap& map_;
};

} // namespace halflight
