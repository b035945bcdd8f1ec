#include "transport/lightmap/batch_gather.h"

#include "transport/lightmap/next_event.h"

#include "halflight/base/parallel.h"

#include <algorithm>

namespace halflight {

/// Texels whose blocks one call of the device takes.
struct BatchGather::Batch {
    std::span<const Request> requests;
    int firstBlock = 0;
    std::vector<DeviceGather::Texel> texels; ///< by request
    std::vector<DeviceGather::Point> points; ///< 16 for each texel
    std::vector<DeviceGather::Block> blocks; ///< texel by texel
};

Status BatchGather::add(std::span<const Request> requests, int firstBlock, const Progress& progress,
                        std::atomic<uint64_t>& rays) const
{
    const bool emission = paths_.light().samplesEmission();
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
        emitted.resize(emission ? batch.blocks.size() : 0);
        uint64_t traced = 0;
        if (Status s = device_.gather(batch.texels, batch.points, batch.blocks, gathered, emitted, traced); !s)
            return s;
        rays += traced;
        forEachIndex(batch.texels.size(), [&](std::size_t i) {
            TexelEstimate& estimate = *batch.requests[i].estimate;
            const std::size_t first = batch.texels[i].firstBlock;
            for (std::size_t b = first; b < first + batch.texels[i].blockCount; ++b) {
                BlockSums::end(gathered[b], estimate, estimate.gathered);
                if (emission) BlockSums::end({emitted[b]}, estimate, estimate.emitted);
            }
        });
        progress("lightmap", double(end) / double(requests.size()));
        begin = end;
    }
    return {};
}

void BatchGather::prepare(Batch& batch) const
{
    const std::size_t count = batch.requests.size();
    batch.texels.assign(count, {});
    batch.points.resize(count * kMaxTexelPoints);
    parallelFor(count, 64, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const uint32_t texel = batch.requests[i].texel;
            const GatherGroup group(paths_, map_, std::span(&texel, 1));
            DeviceGather::Texel& to = batch.texels[i];
            to.id = group.id(0);
            to.firstPoint = uint32_t(i * kMaxTexelPoints);
            to.pointCount = uint32_t(group.pointCount(0));
            if (to.pointCount == 0) continue;
            for (int p = 0; p < group.pointCount(0); ++p) {
                const GatherGroup::Origin& origin = group.origin(0, p);
                batch.points[to.firstPoint + uint32_t(p)] = {origin.position, origin.normal, origin.geometricNormal};
            }
            to.guide = guides_.guideNumberAt(cache_.layout(), group.point(0, 0));
            if (to.guide != ~0u) to.sources = uint32_t(sourceSamplesOf(guides_.guides()[to.guide]));
            to.gathered = batch.requests[i].estimate->gathered.sum;
            to.halfBlocks = batch.requests[i].estimate->gathered.count;
        }
    });
    batch.blocks.clear();
    for (std::size_t i = 0; i < count; ++i) {
        if (batch.texels[i].pointCount == 0) continue;
        batch.texels[i].firstBlock = uint32_t(batch.blocks.size());
        batch.texels[i].blockCount = uint32_t(batch.requests[i].blocks);
        for (int b = 0; b < batch.requests[i].blocks; ++b)
            batch.blocks.push_back({uint32_t(i), uint32_t(batch.firstBlock + b)});
    }
}

/// Kernels without a device: here, because kernels know nothing of lightmaps.
Result<std::unique_ptr<DeviceGather>> RayKernels::prepareGather(const GatherTables& /*tables*/) const
{
    return std::unique_ptr<DeviceGather>();
}

} // namespace halflight
