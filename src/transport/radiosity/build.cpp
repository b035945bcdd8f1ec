#include "transport/radiosity/build.h"

#include "transport/radiosity/device_passes.h"
#include "transport/radiosity/split_patches.h"

#include "halflight/base/atomic_ref.h"
#include "halflight/base/memory.h"
#include "halflight/base/parallel.h"

#include <algorithm>
#include <numeric>
#include <string>

namespace halflight {
namespace {

/// Thins a list of texels out so that large patches are gathered by one texel in `every`. Patches with fewer than 3/4
/// of their texels, or with a texel that is not fully valid, keep all.
void thinOut(std::vector<uint32_t>& texels, const TexelMap& map, const ChartPatches& charts, int every)
{
    if (every == 1) return;
    std::vector<uint8_t> counts(charts.patchCount());
    std::vector<uint8_t> partlyValid(charts.patchCount());
    for (const uint32_t texel : texels) {
        const PatchId patch = charts.patchOf(map, texel);
        if (patch == kNoPatch) continue;
        ++counts[patch];
        if (map.texels[texel].validPoints != kAllPoints) partlyValid[patch] = 1;
    }
    const int enough = 3 << (2 * charts.shift() - 2);
    std::erase_if(texels, [&](uint32_t texel) {
        const PatchId patch = charts.patchOf(map, texel);
        // Diagonal lines, because rows and columns of texels often coincide with features.
        const int line = map.texels[texel].x + every / 2 * map.texels[texel].y;
        return patch != kNoPatch && counts[patch] >= enough && partlyValid[patch] == 0 && line % every != 0;
    });
}

class RadiosityBuilder {
public:
    RadiosityBuilder(const RadiosityInput& input, const Progress& progress, std::atomic<uint64_t>& rays)
        : input_(input), progress_(progress), rays_(rays), patches_(input.paths.surfaces(), input.map)
    {}

    /// Samples all form factors.
    Status runPasses()
    {
        if (Status s = prepareDevice(); !s) return s;
        buildFronts();
        buildBacks();
        gather(PassKind::Elements,
               patches_.texelsIn(input_.map, 0, [](PatchState s) { return s.occluded || s.hitNear; }));
        return status_ ? outcome() : status_;
    }

    Result<Radiosity> build()
    {
        if (Status s = runPasses(); !s) return s.error();
        RadiositySolution solution =
            solveRadiosity(patches_, std::move(factors_), input_.settings.bounces, input_.paths.light().components());
        return Radiosity{std::move(patches_), std::move(solution)};
    }

private:
    /// Parts of a pass that processes share: at most 128, of 4 ranges or more.
    static constexpr std::size_t kMostParts = 128;
    static constexpr std::size_t kFewestRanges = 4;
    [[nodiscard]] Status outcome() const { return input_.paths.surfaces().outcome(!progress_.cancelled()); }
    Status prepareDevice()
    {
        auto device = input_.paths.surfaces().kernels().prepareRadiosity(input_, patches_.layout);
        if (!device) return device.error();
        device_ = std::move(*device);
        return {};
    }
    static bool isOccluded(PatchState s) { return s.occluded; }
    static bool isHit(PatchState s) { return s.hit; }

    void buildFronts()
    {
        std::vector<uint32_t> texels(input_.map.texels.size());
        std::iota(texels.begin(), texels.end(), 0u);
        findOccluded(PassKind::Fronts, texels);
        patches_.split(0, isOccluded);
        findOccluded(PassKind::Elements, patches_.texelsIn(input_.map, 0, isOccluded));
        const int every = effortOf(input_.settings, PassKind::Fronts, patches_.charts.shift()).every;
        thinOut(texels, input_.map, patches_.charts, every);
        gather(PassKind::Fronts, texels);
        markHits();
        patches_.split(0, [](PatchState s) { return s.hitNear; });
    }

    /// Backs and triangles that rays of the fronts hit.
    void buildBacks()
    {
        const uint32_t fronts = patches_.layout.chartPatches;
        const std::vector<uint32_t> backs = patches_.texelsIn(input_.map, fronts, isHit);
        std::vector<uint32_t> triangles;
        for (uint32_t i = 0; i < 2 * patches_.triangles.size(); ++i) {
            if (patches_.state[2 * fronts + i].hit) triangles.push_back(i);
        }
        findOccluded(PassKind::Backs, backs);
        patches_.split(fronts, isOccluded);
        const std::vector<uint32_t> backElements = patches_.texelsIn(input_.map, fronts, isOccluded);
        findOccluded(PassKind::BackElements, backElements);
        gather(PassKind::Backs, backs);
        gather(PassKind::BackElements, backElements);
        gather(PassKind::Triangles, triangles);
    }

    /// Patches that a range of items found occluded.
    struct OccludedPatches {
        std::vector<PatchId> patches;
        template<typename Archive> void archive(Archive& a) { a(patches); }
    };

    static std::size_t rangesOf(std::size_t items) { return (items + kRangeItems - 1) / kRangeItems; }

    /// Fills `out` for ranges of the items by work(items, out), on all threads.
    template<typename Out, typename Work>
    void forRanges(std::span<const uint32_t> items, std::span<Out> out, const Work& work) const
    {
        parallelFor(out.size(), 1, progress_, "bounces", [&](std::size_t begin, std::size_t end) {
            for (std::size_t r = begin; r < end && outcome(); ++r) {
                const std::size_t item = r * kRangeItems;
                work(items.subspan(item, std::min(kRangeItems, items.size() - item)), out[r]);
            }
        });
    }

    /// forRanges() for all items, or onDevice(items, out) where there is a device. Other processes may compute some of
    /// the ranges.
    template<typename Out, typename Work, typename OnDevice>
    void forAllRanges(std::span<const uint32_t> items, std::span<Out> out, const Work& work, const OnDevice& onDevice)
    {
        const std::string name = "radiosity" + std::to_string(passes_++);
        const std::size_t perPart = std::max(kFewestRanges, (out.size() + kMostParts - 1) / kMostParts);
        const auto compute = [&](std::size_t first, std::size_t end) -> Status {
            const std::size_t item = first * kRangeItems;
            const auto some = items.subspan(item, std::min(end * kRangeItems, items.size()) - item);
            const auto ranges = out.subspan(first, end - first);
            if (device_ != nullptr && !some.empty()) {
                if (Status s = onDevice(some, ranges); !s) return s;
            } else {
                forRanges(some, ranges, work);
            }
            return outcome();
        };
        if (status_) status_ = input_.store.computedParts(name, out, perPart, compute);
    }

    void findOccluded(PassKind kind, std::span<const uint32_t> items)
    {
        const PatchPass pass(kind, patches_, input_);
        std::vector<OccludedPatches> found(rangesOf(items.size()));
        const auto search = [&](std::span<const uint32_t> some, OccludedPatches& out) {
            OccluderSearch search(pass);
            search.search(some);
            out.patches = search.occluded();
            rays_ += search.rays();
        };
        forAllRanges(items, std::span(found), search,
                     [&](std::span<const uint32_t> some, std::span<OccludedPatches> out) {
                         return findOccludedOn(*device_, pass, some, out[0].patches, progress_, rays_);
                     });
        for (const OccludedPatches& range : found) {
            for (const PatchId patch : range.patches) patches_.state[patch].occluded = true;
        }
    }

    void gather(PassKind kind, std::span<const uint32_t> items)
    {
        const PatchPass pass(kind, patches_, input_);
        const std::size_t first = factors_.size();
        factors_.resize(first + rangesOf(items.size()));
        for (std::size_t r = first; r < factors_.size(); ++r)
            factors_[r].hasComponents = input_.paths.light().components() > 0;
        const auto sample = [&](std::span<const uint32_t> some, FormFactorRange& out) {
            FormFactorSampler sampler(pass, out);
            sampler.gather(some);
            out.shrink();
            rays_ += sampler.rays();
        };
        forAllRanges(items, std::span(factors_).subspan(first), sample,
                     [&](std::span<const uint32_t> some, std::span<FormFactorRange> out) {
                         return gatherOn(*device_, pass, some, out, progress_, rays_);
                     });
    }

    void markHits()
    {
        // Bytes, as threads may not write the bits of one byte.
        std::vector<uint8_t> hit(patches_.state.size());
        std::vector<uint8_t> hitNear(patches_.state.size());
        const auto mark = [](std::span<const PatchId> patches, std::vector<uint8_t>& marks) {
            for (const PatchId patch : patches) AtomicRef<uint8_t>(marks[patch]).store(1, std::memory_order_relaxed);
        };
        parallelFor(factors_.size(), 16, [&](std::size_t begin, std::size_t end) {
            for (FormFactorRange& range : std::span(factors_).subspan(begin, end - begin)) {
                mark(range.links, hit);
                mark(range.hitNear, hitNear);
                release(range.hitNear);
            }
        });
        forEachIndex(hit.size(), [&](std::size_t i) {
            PatchState& state = patches_.state[i];
            state.hit = state.hit || hit[i] != 0;
            state.hitNear = state.hitNear || hitNear[i] != 0;
        });
    }

    const RadiosityInput& input_;
    const Progress& progress_;
    std::atomic<uint64_t>& rays_;
    Patches patches_;
    FormFactors factors_;
    std::unique_ptr<DeviceRadiosity> device_; ///< null: the processor traces all rays
    int passes_ = 0;                          ///< so far
    Status status_;                           ///< the first error of a pass; those after it do nothing
};

} // namespace

Result<Radiosity> buildRadiosity(const RadiosityInput& input, const Progress& progress, std::atomic<uint64_t>& rays)
{
    return RadiosityBuilder(input, progress, rays).build();
}

Status buildRadiosityParts(const RadiosityInput& input, const Progress& progress, std::atomic<uint64_t>& rays)
{
    return RadiosityBuilder(input, progress, rays).runPasses();
}

} // namespace halflight
