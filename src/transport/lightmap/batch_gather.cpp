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
    std::vector<vec3> ofComponents;          ///< by request and component: what it has gathered before
    // What the device brings: DeviceGather::Light.
    std::vector<DeviceGather::Sums> gathered;
    std::vector<DeviceGather::Halves> emitted, gatheredOf, emittedOf;
};

Status BatchGather::add(std::span<const Request> requests, int firstBlock, const Progress& progress,
                        std::atomic<uint64_t>& rays) const
{
    Batch batch;
    const std::size_t most = DeviceGather::mostBlocks(components_);
    for (std::size_t begin = 0; begin < requests.size();) {
        if (progress.cancelled()) return cancelledError();
        std::size_t end = begin;
        for (std::size_t blocks = 0; end < requests.size(); ++end) {
            blocks += std::size_t(requests[end].blocks);
            if (blocks > most && end > begin) break;
        }
        batch.requests = requests.subspan(begin, end - begin);
        batch.firstBlock = firstBlock;
        prepare(batch);
        uint64_t traced = 0;
        if (Status s = gather(batch, traced); !s) return s;
        rays += traced;
        forEachIndex(batch.texels.size(), [&](std::size_t i) { add(batch, i); });
        progress("lightmap", double(end) / double(requests.size()));
        begin = end;
    }
    return {};
}

Status BatchGather::gather(Batch& batch, uint64_t& rays) const
{
    const std::size_t blocks = batch.blocks.size();
    const std::size_t emitting = samplesEmission_ ? blocks : 0;
    batch.gathered.resize(blocks);
    batch.emitted.resize(emitting);
    batch.gatheredOf.resize(blocks * components_);
    batch.emittedOf.resize(emitting * components_);
    return device_.gather(map_, {batch.texels, batch.blocks, batch.ofComponents},
                          {batch.gathered, batch.emitted, batch.gatheredOf, batch.emittedOf}, rays);
}

/// Adds what the blocks of a request have brought to its estimates.
void BatchGather::add(const Batch& batch, std::size_t number) const
{
    const Request& request = batch.requests[number];
    TexelEstimate& estimate = *request.estimate;
    const std::size_t first = batch.texels[number].firstBlock;
    const auto ofBlock = [&](const std::vector<DeviceGather::Halves>& of, std::size_t b) {
        return std::span(of).subspan(b * components_, components_);
    };
    for (std::size_t b = first; b < first + batch.texels[number].blockCount; ++b) {
        BlockSums::end(batch.gathered[b], estimate, estimate.gathered);
        ComponentSums::end(ofBlock(batch.gatheredOf, b), request.components, &ComponentEstimate::gathered);
        if (!samplesEmission_) continue;
        BlockSums::end({batch.emitted[b]}, estimate, estimate.emitted);
        ComponentSums::end(ofBlock(batch.emittedOf, b), request.components, &ComponentEstimate::emitted);
    }
}

void BatchGather::prepare(Batch& batch) const
{
    batch.texels.clear();
    batch.blocks.clear();
    batch.ofComponents.clear();
    for (const Request& request : batch.requests) {
        const auto first = uint32_t(batch.blocks.size());
        const uint32_t count = map_.texels[request.texel].validPoints != 0 ? uint32_t(request.blocks) : 0;
        for (uint32_t b = 0; b < count; ++b)
            batch.blocks.push_back({uint32_t(batch.texels.size()), uint32_t(batch.firstBlock) + b});
        const RunningMoments& gathered = request.estimate->gathered;
        batch.texels.push_back({request.texel, first, count, gathered.sum, gathered.count});
        for (const ComponentEstimate& of : request.components) batch.ofComponents.push_back(of.gathered.sum);
    }
}

/// Kernels without a device: here, because kernels know nothing of lightmaps.
Result<std::unique_ptr<DeviceGather>> RayKernels::prepareGather(const GatherTables& /*tables*/) const
{
    return std::unique_ptr<DeviceGather>();
}

} // namespace halflight
