#include "transport/texels/valid_points.h"

#include "transport/texels/device_validity.h"
#include "transport/texels/texel_validity.h"

#include "halflight/bake/texel_grid.h"
#include "halflight/base/parallel.h"

#include <algorithm>
#include <array>
#include <mutex>

namespace halflight {
namespace {

constexpr const char* kStage = "validity";
/// Width of a block of texels that few rays test together: of most blocks all points are mutually visible.
constexpr int kBlock = 4;
static_assert(kBlock * kBlock == kMaxTexelPoints, "a point of each texel of a block");
constexpr std::size_t kBlockGrain = 16; ///< blocks
/// Texels of a part that processes share: a few hundredths of a second.
constexpr std::size_t kPartTexels = 16384;

/// Blocks of which a device gets the open texels at once: a sixth of them is open, of 600 bytes each.
constexpr std::size_t kBlocksAtOnce = 16384;

class ValidPoints {
public:
    /// `device`: tests all points of texels where that is needed; may be null.
    ValidPoints(const PathTracer& paths, const TexelMap& map, const DeviceValidity* device, const Progress& progress,
                std::atomic<uint64_t>& rays)
        : paths_(paths), map_(map), device_(device), progress_(progress), rays_(rays),
          validity_(paths, device != nullptr), grid_(map)
    {}

    /// Masks of the texels [begin, end).
    Status find(std::size_t begin, std::size_t end, std::span<PointMask> masks) const
    {
        const std::vector<uint32_t> blocks = blocksOf(begin, end);
        const std::size_t atOnce = device_ != nullptr ? kBlocksAtOnce : blocks.size();
        Status tested; // by the device; read once it has finished
        Background device;
        for (std::size_t first = 0; first < blocks.size(); first += atOnce) {
            const std::size_t last = std::min(first + atOnce, blocks.size());
            const auto shareOf = [&](std::size_t block) { return double(block) / double(blocks.size()); };
            const Progress part = partOf(progress_, shareOf(first), shareOf(last));
            std::vector<Open> parts;
            Status s;
            inIsolation(
                [&] { s = testBlocks(std::span(blocks).subspan(first, last - first), begin, masks, parts, part); });
            device.wait(); // one list of open texels at a time: it may take 150 MB
            if (!s || !tested) return s ? tested : s;
            device.run([this, begin, masks, &tested, parts = std::move(parts)]() mutable {
                tested = testOpen(inOrder(parts), begin, masks);
            });
        }
        device.wait();
        return tested;
    }

private:
    /// Texels that the device tests, of the blocks from `firstBlock` on.
    struct Open {
        std::size_t firstBlock = 0;
        std::vector<uint32_t> texels;
        std::vector<DeviceValidity::Texel> points; ///< theirs

        void add(const Open& others)
        {
            texels.insert(texels.end(), others.texels.begin(), others.texels.end());
            points.insert(points.end(), others.points.begin(), others.points.end());
        }
    };

    /// Masks of the texels of some blocks, from texel `begin` on, but for open ones.
    Status testBlocks(std::span<const uint32_t> blocks, std::size_t begin, std::span<PointMask> masks,
                      std::vector<Open>& open, const Progress& progress) const
    {
        std::mutex mutex;
        const bool finished =
            parallelFor(blocks.size(), kBlockGrain, progress, kStage, [&](std::size_t first, std::size_t last) {
                uint64_t traced = 0;
                Open some{first, {}, {}};
                for (std::size_t i = first; i < last && !progress.cancelled() && !paths_.surfaces().failed(); ++i) {
                    forChartsOf(blocks[i], [&](std::span<BlockTexel> members) {
                        for (BlockTexel& m : members) m.wanted = m.texel >= begin && m.texel - begin < masks.size();
                        validity_.testBlock(members, traced);
                        for (const BlockTexel& m : members) {
                            if (m.wanted) masks[m.texel - begin] = m.valid;
                            if (m.open) leaveOpen(m, some);
                        }
                    });
                }
                rays_ += traced;
                if (some.texels.empty()) return;
                const std::lock_guard lock(mutex);
                open.push_back(std::move(some));
            });
        return paths_.surfaces().outcome(finished);
    }

    /// All parts, in the order of their blocks: on some devices a ray's neighbours decide what it hits at an edge.
    static Open inOrder(std::vector<Open>& parts)
    {
        std::ranges::sort(parts, {}, &Open::firstBlock);
        Open all;
        for (const Open& part : parts) all.add(part);
        return all;
    }

    void leaveOpen(const BlockTexel& from, Open& open) const
    {
        DeviceValidity::Texel to{from.id, uint32_t(from.pointCount), {}};
        for (std::size_t p = 0; p < to.pointCount; ++p) {
            const SurfacePoint& point = from.points[p];
            to.points[p] = {paths_.surfaces().rayOrigin(point), point.normal, point.geometricNormal};
        }
        open.texels.push_back(from.texel);
        open.points.push_back(to);
    }

    Status testOpen(const Open& open, std::size_t begin, std::span<PointMask> masks) const
    {
        if (open.texels.empty()) return {};
        std::vector<PointMask> found(open.texels.size());
        uint64_t traced = 0;
        if (Status s = device_->validPoints(open.points, found, traced); !s) return s;
        rays_ += traced;
        for (std::size_t i = 0; i < found.size(); ++i) masks[open.texels[i] - begin] = found[i];
        return {};
    }

    [[nodiscard]] const BakeGeometry& geometry() const { return paths_.surfaces().geometry(); }
    [[nodiscard]] uint32_t blocksPerRow() const { return uint32_t(map_.pageSize + kBlock - 1) / uint32_t(kBlock); }

    /// Blocks that hold the texels [begin, end): their places on the pages, row by row.
    [[nodiscard]] std::vector<uint32_t> blocksOf(std::size_t begin, std::size_t end) const
    {
        const uint32_t perRow = blocksPerRow();
        std::vector<uint8_t> found(std::size_t(perRow) * perRow * std::size_t(map_.pageCount));
        for (std::size_t i = begin; i < end; ++i) {
            const Texel& t = map_.texels[i];
            found[(t.page * perRow + t.y / kBlock) * std::size_t(perRow) + t.x / kBlock] = 1;
        }
        std::vector<uint32_t> blocks;
        for (std::size_t b = 0; b < found.size(); ++b)
            if (found[b] != 0) blocks.push_back(uint32_t(b));
        return blocks;
    }

    /// Calls body(members) for the texels of each chart in a block.
    template<typename Body> void forChartsOf(uint32_t block, const Body& body) const
    {
        const uint32_t perRow = blocksPerRow();
        const uint32_t page = block / (perRow * perRow);
        const auto corner = vec2(block % perRow, block / perRow % perRow) * float(kBlock);
        std::array<uint32_t, std::size_t(kBlock) * kBlock> inside;
        std::size_t left = 0;
        for (int i = 0; i < kBlock * kBlock; ++i) {
            const uint32_t texel = grid_.atPlace(page, corner + vec2(i % kBlock, i / kBlock) + 0.5f);
            if (texel != kNoTexel) inside[left++] = texel;
        }
        std::array<BlockTexel, inside.size()> members;
        for (std::size_t end = 0; left > 0; left = end) {
            const uint32_t chart = map_.texels[inside[0]].chart;
            std::size_t count = 0;
            end = 0;
            for (std::size_t i = 0; i < left; ++i) {
                const Texel& t = map_.texels[inside[i]];
                if (t.chart != chart) {
                    inside[end++] = inside[i];
                    continue;
                }
                BlockTexel& m = members[count++];
                m = {};
                m.texel = inside[i];
                m.id = texelId(map_, t);
                m.pointCount = texelPoints(geometry(), map_, t, m.points);
            }
            body(std::span(members.data(), count));
        }
    }

    const PathTracer& paths_;
    const TexelMap& map_;
    const DeviceValidity* device_;
    const Progress& progress_;
    std::atomic<uint64_t>& rays_;
    TexelValidity validity_;
    TexelGrid grid_;
};

} // namespace

Status findValidPoints(const PathTracer& paths, TexelMap& map, const Store& store, const Progress& progress,
                       std::atomic<uint64_t>& rays)
{
    std::vector<PointMask> masks;
    const Status done = store.computed(kStage, masks, [&] {
        masks.resize(map.texels.size());
        const auto device = paths.surfaces().kernels().prepareValidity();
        if (!device) return Status(device.error());
        const ValidPoints points(paths, map, device->get(), progress, rays);
        return store.computedParts(kStage, std::span(masks), kPartTexels, [&](std::size_t begin, std::size_t end) {
            return points.find(begin, end, std::span(masks).subspan(begin, end - begin));
        });
    });
    if (!done) return done;
    if (masks.size() != map.texels.size())
        return Error{ErrorCode::FileInvalid, "the cache has validity of another map"};
    forEachIndex(masks.size(), [&](std::size_t i) { map.texels[i].validPoints = masks[i]; });
    return {};
}

Status findValidPoints(const PathTracer& paths, std::span<const SurfacePoint> points, std::span<uint8_t> out)
{
    const TexelValidity validity(paths);
    parallelFor(points.size(), 64, [&](std::size_t begin, std::size_t end) {
        TexelPoints one;
        uint64_t rays = 0;
        for (std::size_t i = begin; i < end; ++i) {
            if (out[i] == 0) continue;
            one[0] = points[i];
            out[i] = validity.validPoints(one, 1, uint32_t(i), rays) != 0 ? 1 : 0;
        }
    });
    return paths.surfaces().outcome(true);
}

/// Kernels without a device: here, because kernels know nothing of texels.
Result<std::unique_ptr<DeviceValidity>> RayKernels::prepareValidity() const
{
    return std::unique_ptr<DeviceValidity>();
}

} // namespace halflight
