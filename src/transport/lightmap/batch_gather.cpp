#include "transport/lightmap/batch_gather.h"

#include "halflight/base/parallel.h"

#include <algorithm>

namespace halflight {

/// Texels whose blocks one call of the device takes.
struct BatchGather::Batch {
    std::span<const Request> requests;
    int firstBlock = 0;
    std::vector<DeviceGather::Texel> texels; ///< by request
    std::vector<DeviceGather::Block> blocks; ///< texel by texel
};

Status BatchGather::add(std::span<const Request> requests, int firstBlock, const Progress& progress,
                        std::atomic<uint64_t>& rays) const
{
    Batch batch;
    std::vector<DeviceGather::Sums> gathered;
    std::vector<DeviceGather::Halves> emitted;
    for (std::size_t begin = 0; begin < requests.size();) {
        if (progress.cancelled()) return cancelledError();
        std::size_t end = begin;
        for (std::size_t blocks = 0; end < requests.size(); ++end) {
            blocks += std::size_t(requests[end].blocks);
            if (blocks > DeviceGather::kMostBlocks && end > begin) break;
        }
        batch.requests = requests.subspan(begin, end - begin);
        batch.firstBlock = firstBlock;
        prepare(batch);
        gathered.resize(batch.blocks.size());
        emitted.resize(samplesEmission_ ? batch.blocks.size() : 0);
        uint64_t traced = 0;
        if (Status s = device_.gather(map_, batch.texels, batch.blocks, gathered, emitted, traced); !s) return s;
        rays += traced;
        forEachIndex(batch.texels.size(), [&](std::size_t i) {
            TexelEstimate& estimate = *batch.requests[i].estimate;
            const std::size_t first = batch.texels[i].firstBlock;
            for (std::size_t b = first; b < first + batch.texels[i].blockCount; ++b) {
                BlockSums::end(gathered[b], estimate, estimate.gathered);
                if (samplesEmission_) BlockSums::end({emitted[b]}, estimate, estimate.emitted);
            }
        });
        progress("lightmap", double(end) / double(requests.size()));
        begin = end;
    }
    return {};
}

void BatchGather::prepare(Batch& batch) const
{
    batch.texels.clear();
    batch.blocks.clear();
    for (const Request& request : batch.requests) {
        const auto first = uint32_t(batch.blocks.size());
        const uint32_t count = map_.texels[request.texel].validPoints != 0 ? uint32_t(request.blocks) : 0;
        for (uint32_t b = 0; b < count; ++b)
            batch.blocks.push_back({uint32_t(batch.texels.size()), uint32_t(batch.firstBlock) + b});
        const RunningMoments& gathered = request.estimate->gathered;
        batch.texels.push_back({request.texel, first, count, gathered.sum, gathered.count});
    }
}

/// Kernels without a device: here, because kernels know nothing of lightmaps.
Result<std::unique_ptr<DeviceGather>> RayKernels::prepareGather(const GatherTables& /*tables*/) const
{
    return std::unique_ptr<DeviceGather>();
}

} // namespace halflight
