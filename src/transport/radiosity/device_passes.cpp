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
using LightPart = DeviceRadiosity::LightPart;
using Traced = DeviceRadiosity::Traced;

/// Adds what a device has traced for a range of items, in the order of FormFactorSampler.
class TracedFactors {
public:
    TracedFactors(const PatchPass& pass, FormFactorRange& out)
        : pass_(pass), light_(pass.input().paths.light()), components_(light_.components()),
          parts_(DeviceRadiosity::partsOf(light_)), out_(out), effort_(effortOf(pass)), again_(pass, out)
    {}

    void add(std::span<const uint32_t> items, const Traced& traced)
    {
        const auto strata = std::size_t(effort_.strata());
        const std::size_t perItem = std::size_t(effort_.blocks()) * strata;
        const auto samples = std::size_t(effort_.direct);
        for (std::size_t first = 0; first < items.size(); first += kLanes) {
            const std::size_t end = std::min(first + kLanes, items.size());
            const uint32_t group = pass_.kind() == PassKind::Triangles ? 0 : effort_.groupOf(items[first]);
            for (int b = 0; b < effort_.blocks(); ++b) {
                for (std::size_t i = first; i < end; ++i) {
                    const std::size_t ray = i * perItem + std::size_t(b) * strata;
                    addBlock(items[i], group, b, traced, ray, strata);
                }
            }
            for (std::size_t s = 0; s < samples; ++s) {
                for (std::size_t i = first; i < end; ++i) {
                    const std::size_t sample = i * samples + s;
                    addDirect(traced.direct[sample], traced.parts.subspan(sample * parts_, parts_));
                }
            }
        }
    }
    [[nodiscard]] uint64_t rays() const { return again_.rays(); }

private:
    /// Those of an element follow one another, so that it has one entry of samples. `first`: the block's first ray.
    void addBlock(uint32_t item, uint32_t group, int block, const Traced& traced, std::size_t first, std::size_t strata)
    {
        std::array<std::pair<PatchId, uint32_t>, StratifiedPattern::kBlock> order; // source and stratum
        std::array<uint8_t, StratifiedPattern::kBlock> numberOf{};                 // by stratum
        for (std::size_t n = 0; n < strata; ++n) {
            const auto stratum = uint32_t(shading::factorStratum(int(n), int(strata / 4), group));
            order[n] = {traced.rays[first + n].source, stratum};
            numberOf[stratum] = uint8_t(n);
        }
        if (pass_.ofElements()) std::sort(order.begin(), order.begin() + std::ptrdiff_t(strata));
        for (std::size_t n = 0; n < strata; ++n) {
            const auto [source, stratum] = order[n];
            if (source != kNoPatch) addRay(item, block, uint8_t(stratum), traced, first + numberOf[stratum]);
        }
    }

    /// Adds radiance of the sky or of an emitter.
    void addGathered(PatchSamples& samples, const FactorRay& ray, vec3 tint, int emitter)
    {
        if (components_ == 0) {
            samples.gathered += tint * ray.gathered;
            return;
        }
        const auto add = [&](int component, vec3 radiance) {
            samples.gathered += tint * radiance;
            out_.componentsOf(samples, components_)[std::size_t(component)].gathered += tint * radiance;
        };
        if (ray.target != DeviceRadiosity::kLeaves)
            add(emitter, ray.gathered);
        else if (light_.splitsSky())
            light_.splitShares(ray.gathered, add);
        else
            add(light_.skyComponent(), ray.gathered);
    }

    /// `number`: of the ray among those traced.
    void addRay(uint32_t item, int block, uint8_t stratum, const Traced& traced, std::size_t number)
    {
        const FactorRay& ray = traced.rays[number];
        const vec3 tint = traced.tints.empty() ? vec3(1.0f) : traced.tints[number];
        if (ray.target == DeviceRadiosity::kOpen) {
            addOpen(item, block, stratum);
            return;
        }
        PatchSamples& samples = out_.last(ray.source);
        ++samples.rayCount;
        addGathered(samples, ray, tint, components_ > 0 ? int(traced.emitters[number]) : 0);
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

    void addDirect(const DirectSample& sample, std::span<const LightPart> parts)
    {
        if (sample.source == kNoPatch) return;
        PatchSamples& sums = out_.recent(sample.source);
        sums.direct += sample.irradiance;
        sums.albedo += sample.albedo;
        sums.lobes.add(sample.lobes);
        ++sums.directCount;
        sums.minDistance = std::max(sums.minDistance, sample.minDistance);
        if (components_ == 0) return;
        const std::span<ComponentSamples> components = out_.componentsOf(sums, components_);
        for (const LightPart& part : parts) {
            ComponentSamples& own = components[part.component];
            own.direct += part.irradiance;
            own.exitance += part.exitance;
            own.sampledExitance += part.sampledExitance;
            own.sampledMoment += part.sampledMoment;
        }
    }

    const PatchPass& pass_;
    const SceneLight& light_;
    int components_;
    std::size_t parts_; ///< of a light sample
    FormFactorRange& out_;
    FormFactorEffort effort_;
    FormFactorSampler again_;
    std::optional<GatherGroup> group_; ///< points of the item whose rays were traced again last
    uint32_t itemOfGroup_ = 0;
};

/// A part of a list, which may be empty.
template<typename T> std::span<T> partOf(std::span<T> list, std::size_t first, std::size_t count)
{
    return list.empty() ? list : list.subspan(first, count);
}

/// Calls work(items, first) for `most` items at a time, from the first on.
template<typename Work>
Status forCalls(std::span<const uint32_t> items, std::size_t most, const Progress& progress, const Work& work)
{
    for (std::size_t first = 0; first < items.size(); first += most) {
        if (progress.cancelled()) return cancelledError();
        const auto some = items.subspan(first, std::min(items.size() - first, most));
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
    const std::size_t most = DeviceRadiosity::kMostItems;
    return forCalls(items, most, progress, [&](std::span<const uint32_t> some, std::size_t /*first*/) {
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
    const std::size_t parts = DeviceRadiosity::partsOf(pass.input().paths.light());
    const auto use = [&](std::span<const uint32_t> some, std::size_t first, const Traced& traced) {
        const auto ranges = out.subspan(first / kRangeItems, (some.size() + kRangeItems - 1) / kRangeItems);
        parallelFor(ranges.size(), 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t r = begin; r < end; ++r) {
                const std::size_t item = r * kRangeItems;
                const std::size_t count = std::min(kRangeItems, some.size() - item);
                TracedFactors factors(pass, ranges[r]);
                const std::size_t ray = item * raysOfItem;
                const std::size_t rayCount = count * raysOfItem;
                const std::size_t direct = item * directOfItem;
                const std::size_t directCount = count * directOfItem;
                factors.add(some.subspan(item, count),
                            {traced.rays.subspan(ray, rayCount), traced.direct.subspan(direct, directCount),
                             partOf(traced.tints, ray, rayCount), partOf(traced.emitters, ray, rayCount),
                             traced.parts.subspan(direct * parts, directCount * parts)});
                ranges[r].shrink();
                rays += factors.rays();
            }
        });
    };
    Background users; // of what a call has traced, while the next one traces
    const Status done =
        forCalls(items, device.mostItems(), progress, [&](std::span<const uint32_t> some, std::size_t first) {
            uint64_t count = 0;
            Traced traced;
            Status s;
            inIsolation([&] { s = device.gather(some, traced, count); });
            rays += count;
            users.wait();
            if (s) users.run([&use, some, first, traced] { use(some, first, traced); });
            return s;
        });
    users.wait();
    return done;
}

/// Kernels without a device: here, because kernels know nothing of patches.
Result<std::unique_ptr<DeviceRadiosity>> RayKernels::prepareRadiosity(const RadiosityInput& /*input*/,
                                                                      const PatchLayout& /*layout*/) const
{
    return std::unique_ptr<DeviceRadiosity>();
}

} // namespace halflight
