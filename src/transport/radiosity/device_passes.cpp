#include "transport/radiosity/device_passes.h"

#include "halflight/base/parallel.h"
#include "halflight/shading/form_factors.h"

#include <algorithm>
#include <array>
#include <optional>

namespace halflight {
namespace {

using FactorRay = DeviceRadiosity::FactorRay;
using DirectSample = DeviceRadiosity::DirectSample;

/// Adds what a device has traced for a range of items, in the order of FormFactorSampler.
class TracedFactors {
public:
    TracedFactors(const PatchPass& pass, FormFactorRange& out)
        : pass_(pass), out_(out), effort_(effortOf(pass)), again_(pass, out)
    {}

    void add(std::span<const uint32_t> items, const DeviceRadiosity::Traced& traced)
    {
        const auto strata = std::size_t(effort_.strata());
        const std::size_t perItem = std::size_t(effort_.blocks()) * strata;
        const auto samples = std::size_t(effort_.direct);
        for (std::size_t first = 0; first < items.size(); first += kLanes) {
            const std::size_t end = std::min(first + kLanes, items.size());
            const uint32_t group = pass_.kind() == PassKind::Triangles ? 0 : effort_.groupOf(items[first]);
            for (int b = 0; b < effort_.blocks(); ++b) {
                for (std::size_t i = first; i < end; ++i) {
                    const std::size_t begin = i * perItem + std::size_t(b) * strata;
                    addBlock(items[i], group, b, traced.rays.subspan(begin, strata),
                             partOf(traced.tints, begin, strata));
                }
            }
            for (std::size_t s = 0; s < samples; ++s) {
                for (std::size_t i = first; i < end; ++i) addDirect(traced.direct[i * samples + s]);
            }
        }
    }
    [[nodiscard]] uint64_t rays() const { return again_.rays(); }
    /// A part of a list, which may be empty.
    static std::span<const vec3> partOf(std::span<const vec3> list, std::size_t first, std::size_t count)
    {
        return list.empty() ? list : list.subspan(first, count);
    }

private:
    /// Those of an element follow one another, so that it has one entry of samples.
    void addBlock(uint32_t item, uint32_t group, int block, std::span<const FactorRay> rays,
                  std::span<const vec3> tints)
    {
        std::array<std::pair<PatchId, uint32_t>, StratifiedPattern::kBlock> order; // source and stratum
        std::array<uint8_t, StratifiedPattern::kBlock> numberOf{};                 // by stratum
        for (std::size_t n = 0; n < rays.size(); ++n) {
            const auto stratum = uint32_t(shading::factorStratum(int(n), int(rays.size() / 4), group));
            order[n] = {rays[n].source, stratum};
            numberOf[stratum] = uint8_t(n);
        }
        if (pass_.ofElements()) std::sort(order.begin(), order.begin() + std::ptrdiff_t(rays.size()));
        for (std::size_t n = 0; n < rays.size(); ++n) {
            const auto [source, stratum] = order[n];
            const uint8_t number = numberOf[stratum];
            if (source != kNoPatch)
                addRay(item, block, uint8_t(stratum), rays[number], tints.empty() ? vec3(1.0f) : tints[number]);
        }
    }

    void addRay(uint32_t item, int block, uint8_t stratum, const FactorRay& ray, vec3 tint)
    {
        if (ray.target == DeviceRadiosity::kOpen) {
            addOpen(item, block, stratum);
            return;
        }
        PatchSamples& samples = out_.last(ray.source);
        ++samples.rayCount;
        samples.gathered += ray.gathered;
        if (ray.target == DeviceRadiosity::kLeaves) return;
        const PatchId target = ray.target & ~DeviceRadiosity::kNearBit;
        if (tint != vec3(1.0f)) out_.tinted.push_back({uint32_t(out_.links.size()), tint});
        out_.links.push_back(target);
        ++samples.linkCount;
        if (target == ray.target) return;
        out_.hitNear.push_back(target);
        if (ray.source < pass_.layout().chartPatches) out_.hitNear.push_back(ray.source);
    }

    void addOpen(uint32_t item, int block, uint8_t stratum)
    {
        if (!group_ || itemOfGroup_ != item) {
            pass_.forGroups({&item, 1}, [&](const TexelGroup& group) { group_.emplace(pass_.input().paths, group); });
            itemOfGroup_ = item;
        }
        again_.traceAgain(*group_, block, stratum);
    }

    void addDirect(const DirectSample& sample)
    {
        if (sample.source == kNoPatch) return;
        PatchSamples& sums = out_.recent(sample.source);
        sums.direct += sample.irradiance;
        sums.albedo += sample.albedo;
        sums.lobes.add(sample.lobes);
        ++sums.directCount;
        sums.minDistance = std::max(sums.minDistance, sample.minDistance);
    }

    const PatchPass& pass_;
    FormFactorRange& out_;
    FormFactorEffort effort_;
    FormFactorSampler again_;
    std::optional<GatherGroup> group_; ///< points of the item whose rays were traced again last
    uint32_t itemOfGroup_ = 0;
};

/// Calls work(items, first) for as many items as one call of the device takes, from the first on.
template<typename Work> Status forCalls(std::span<const uint32_t> items, const Progress& progress, const Work& work)
{
    for (std::size_t first = 0; first < items.size(); first += DeviceRadiosity::kMostItems) {
        if (progress.cancelled()) return cancelledError();
        const auto some = items.subspan(first, std::min(items.size() - first, DeviceRadiosity::kMostItems));
        if (Status s = work(some, first); !s) return s;
        progress("bounces", double(first + some.size()) / double(items.size()));
    }
    return {};
}

} // namespace

Status findOccludedOn(DeviceRadiosity& device, const PatchPass& pass, std::span<const uint32_t> items,
                      std::vector<PatchId>& found, const Progress& progress, std::atomic<uint64_t>& rays)
{
    if (items.empty()) return {};
    if (Status s = device.begin(pass); !s) return s;
    return forCalls(items, progress, [&](std::span<const uint32_t> some, std::size_t /*first*/) {
        uint64_t traced = 0;
        Status s = device.findOccluded(some, found, traced);
        rays += traced;
        return s;
    });
}

Status gatherOn(DeviceRadiosity& device, const PatchPass& pass, std::span<const uint32_t> items,
                std::span<FormFactorRange> out, const Progress& progress, std::atomic<uint64_t>& rays)
{
    if (items.empty()) return {};
    if (Status s = device.begin(pass); !s) return s;
    const FormFactorEffort effort = effortOf(pass);
    const auto raysOfItem = std::size_t(effort.blocks() * effort.strata());
    const auto directOfItem = std::size_t(effort.direct);
    return forCalls(items, progress, [&](std::span<const uint32_t> some, std::size_t first) {
        const auto ranges = out.subspan(first / kRangeItems, (some.size() + kRangeItems - 1) / kRangeItems);
        const auto use = [&](const DeviceRadiosity::Traced& traced) {
            parallelFor(ranges.size(), 1, [&](std::size_t begin, std::size_t end) {
                for (std::size_t r = begin; r < end; ++r) {
                    const std::size_t item = r * kRangeItems;
                    const std::size_t count = std::min(kRangeItems, some.size() - item);
                    TracedFactors factors(pass, ranges[r]);
                    factors.add(some.subspan(item, count),
                                {traced.rays.subspan(item * raysOfItem, count * raysOfItem),
                                 TracedFactors::partOf(traced.tints, item * raysOfItem, count * raysOfItem),
                                 traced.direct.subspan(item * directOfItem, count * directOfItem)});
                    ranges[r].shrink();
                    rays += factors.rays();
                }
            });
        };
        uint64_t traced = 0;
        Status s = device.gather(some, use, traced);
        rays += traced;
        return s;
    });
}

/// Kernels without a device: here, because kernels know nothing of patches.
Result<std::unique_ptr<DeviceRadiosity>> RayKernels::prepareRadiosity(const RadiosityInput& /*input*/,
                                                                      const PatchLayout& /*layout*/) const
{
    return std::unique_ptr<DeviceRadiosity>();
}

} // namespace halflight
