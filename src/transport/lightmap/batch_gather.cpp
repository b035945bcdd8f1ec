#include "transport/lightmap/batch_gather.h"

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
    std::vector<std::size_t> firstOfTexel;   ///< index of its first block; then their number
};

Status BatchGather::add(std::span<const Request> requests, int firstBlock, const Progress& progress,
                        std::atomic<uint64_t>& rays) const
{
    std::vector<DeviceGather::Sums> sums;
    std::vector<DeviceGather::EmitterHit> emissive;
    for (std::size_t begin = 0; begin < requests.size();) {
        if (progress.cancelled()) return cancelledError();
        std::size_t end = begin;
        for (std::size_t blocks = 0; end < requests.size(); ++end) {
            blocks += std::size_t(requests[end].blocks);
            if (blocks > DeviceGather::kMostBlocks && end > begin) break;
        }
        Batch batch{requests.subspan(begin, end - begin), firstBlock, {}, {}, {}, {}};
        prepare(batch);
        sums.resize(batch.blocks.size());
        uint64_t traced = 0;
        if (Status s = device_.gather(batch.texels, batch.points, batch.blocks, sums, emissive, traced); !s) return s;
        rays += traced;
        finish(batch, sums, emissive, rays);
        progress("lightmap", double(end) / double(requests.size()));
        begin = end;
    }
    return {};
}

void BatchGather::prepare(Batch& batch) const
{
    const std::size_t count = batch.requests.size();
    batch.texels.resize(count);
    batch.points.resize(count * kMaxTexelPoints);
    batch.firstOfTexel.assign(count + 1, 0);
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
        }
    });
    for (std::size_t i = 0; i < count; ++i) {
        batch.firstOfTexel[i] = batch.blocks.size();
        if (batch.texels[i].pointCount == 0) continue;
        for (int b = 0; b < batch.requests[i].blocks; ++b)
            batch.blocks.push_back({uint32_t(i), uint32_t(batch.firstBlock + b)});
    }
    batch.firstOfTexel[count] = batch.blocks.size();
}

void BatchGather::finish(const Batch& batch, std::span<const DeviceGather::Sums> sums,
                         std::span<const DeviceGather::EmitterHit> emissive, std::atomic<uint64_t>& rays) const
{
    const auto emissiveFrom = [&](std::size_t block) {
        return emissive.begin() +
               (std::lower_bound(emissive.begin(), emissive.end(), block,
                                 [](const DeviceGather::EmitterHit& hit, std::size_t b) { return hit.block < b; }) -
                emissive.begin());
    };
    parallelFor(batch.requests.size(), kLanes, [&](std::size_t begin, std::size_t end) {
        FinalGather gather = makeGather();
        uint64_t traced = 0;
        for (std::size_t i = begin; i < end; i += kLanes) {
            std::array<uint32_t, kLanes> texels{};
            std::array<FinalGather::TracedBlocks, kLanes> blocks;
            const std::size_t lanes = std::min(end - i, std::size_t(kLanes));
            for (std::size_t k = 0; k < lanes; ++k) {
                const std::size_t first = batch.firstOfTexel[i + k];
                const std::size_t last = batch.firstOfTexel[i + k + 1];
                texels[k] = batch.requests[i + k].texel;
                blocks[k] = {batch.firstBlock,
                             first,
                             sums.subspan(first, last - first),
                             {emissiveFrom(first), emissiveFrom(last)},
                             std::span(batch.points).subspan(batch.texels[i + k].firstPoint, kMaxTexelPoints),
                             int(batch.texels[i + k].pointCount),
                             batch.texels[i + k].id,
                             batch.requests[i + k].estimate};
            }
            gather.finish(map_, std::span<const uint32_t>(texels.data(), lanes), blocks, traced);
        }
        rays += traced;
    });
}

/// Kernels without a device: here, because kernels know nothing of lightmaps.
Result<std::unique_ptr<DeviceGather>> RayKernels::prepareGather(const GatherTables& /*tables*/) const
{
    return std::unique_ptr<DeviceGather>();
}

} // namespace halflight
