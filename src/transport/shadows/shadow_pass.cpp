#include "transport/shadows/shadow_pass.h"

#include "transport/shadows/batch_shadows.h"
#include "transport/texels/texel_set.h"

#include "halflight/base/memory.h"

#include <algorithm>
#include <cassert>

namespace halflight {
namespace {

/// Texels within this distance have to agree: 49 texels have 392 rays, so that the rim of a penumbra is found. Less
/// than a third of them, on a small chart, is no evidence.
constexpr int kAgreeRadius = 3;
constexpr int kEnoughTexels = (2 * kAgreeRadius + 1) * (2 * kAgreeRadius + 1) / 3;
/// Most rays of a texel to a light: each of them still counts in the sums.
constexpr int kMostRays = 1 << 16;
/// An even number of half-batches.
constexpr int kMostHalves = kMostRays / (2 * ShadowRays::kHalf) * 2;

class ShadowTracer {
public:
    ShadowTracer(const ShadowPass& pass, const std::vector<ShadowSource>& sources, std::vector<LitSum>& counts,
                 std::vector<vec3>& colors)
        : pass_(pass), sources_(sources), counts_(counts), colors_(colors), asked_(pass.map, pass.texels), set_(asked_)
    {
        set_.extend([&](uint32_t texel, const auto& add) { pass.grid.around(texel, kAgreeRadius, add); });
        whole_ = set_.size() == asked_.size();
    }

    Status trace()
    {
        if (Status s = traceFirst(); !s) return s;
        findOpen();
        release(first_);
        const int halves = ShadowRays::halvesOf(pass_.samples);
        const int firstHalves = std::max(2, halves / 4 * 2);
        const int lastHalves = std::min(pass_.timesOnEdges * halves, kMostHalves);
        const int nextHalves = std::min(2 * firstHalves, lastHalves);
        if (Status s = traceHalves(0, firstHalves, partOf(pass_.progress, 0.5, 0.7)); !s) return s;
        keepOpen(BesideEdge);
        if (Status s = traceHalves(firstHalves, nextHalves, partOf(pass_.progress, 0.7, 0.85)); !s) return s;
        keepOpen(Closed);
        return traceHalves(nextHalves, lastHalves, partOf(pass_.progress, 0.85, 1.0));
    }

private:
    enum Open : uint8_t { Closed, Undecided, BesideEdge };

    /// Of a texel of the pass.
    [[nodiscard]] PointMask validPoints(std::size_t i) const { return pass_.map.texels[pass_.texels[i]].validPoints; }
    [[nodiscard]] std::size_t sourceCount() const { return sources_.size(); }
    [[nodiscard]] bool isAsked(uint32_t texel, std::size_t& number) const
    {
        number = asked_.find(texel);
        return whole_ || (number < asked_.size() && asked_[number] == texel);
    }

    /// 8 rays from points of all texels and their neighbours, valid or not.
    Status traceFirst()
    {
        first_ = largeVector<LitRange>(set_.size() * sourceCount());
        const Progress part = partOf(pass_.progress, 0.0, 0.5);
        if (pass_.device != nullptr) return traceFirstOnDevice(part);
        return forTexelGroups(
            pass_.paths.surfaces(), set_.size(), [&](std::size_t i) { return set_[i]; },
            [&](std::span<const uint32_t> texels) {
                return ShadowGroup(pass_.paths, pass_.map, texels, PointUse::All);
            },
            part, pass_.stage, pass_.rays,
            [&] {
                return [&](const ShadowGroup& group, std::size_t first, uint64_t& rays) {
                    traceFirst(group, first, rays);
                };
            });
    }
    void traceFirst(const ShadowGroup& group, std::size_t first, uint64_t& rays)
    {
        // The rays of a texel with invalid points do not count.
        constexpr std::size_t kNone = ~std::size_t(0);
        std::array<std::size_t, kLanes> counted;
        counted.fill(kNone);
        for (int lane = 0; lane < group.lanes(); ++lane) {
            std::size_t number = 0;
            if (isAsked(group.texel(lane), number) && validPoints(number) == kAllPoints)
                counted[std::size_t(lane)] = number * sourceCount();
        }
        for (std::size_t s = 0; s < sourceCount(); ++s) {
            const ShadowRays shadows(pass_.paths, pass_.pattern, sources_[s]);
            const ShadowRays::Sums sums = shadows.trace(group, ~0u, 0, rays);
            for (std::size_t lane = 0; lane < std::size_t(group.lanes()); ++lane) {
                first_[(first + lane) * sourceCount() + s] = sums.lit[lane].range;
                if (counted[lane] != kNone) add(counted[lane] + s, sums, lane);
            }
        }
    }

    Status traceFirstOnDevice(const Progress& progress)
    {
        const auto fill = [](std::size_t, std::span<DeviceShadows::Item> items) {
            for (std::size_t s = 0; s < items.size(); ++s) items[s] = {0, 0, kAllPoints, uint16_t(s)};
        };
        const auto use = [&](std::size_t i, const BatchShadows::Sums& sums) {
            std::size_t number = 0;
            const bool counted = isAsked(set_[i], number) && validPoints(number) == kAllPoints;
            for (std::size_t s = 0; s < sums.lit.size(); ++s) {
                first_[i * sourceCount() + s] = sums.lit[s].range;
                if (counted) add(number * sourceCount() + s, sums, s);
            }
        };
        const auto countOf = [&](std::size_t) { return sourceCount(); };
        return BatchShadows(*pass_.device, pass_.map, sources_, !colors_.empty())
            .trace(set_.texels(), countOf, fill, use, progress, pass_.stage, pass_.rays);
    }

    /// First rays of a texel, a bit for each source.
    struct Seen {
        uint32_t notLit = 0;  ///< some ray brings less than all
        uint32_t notDark = 0; ///< some ray brings something
        uint32_t mixed = 0;   ///< the rays disagree

        void add(const Seen& other)
        {
            notLit |= other.notLit;
            notDark |= other.notDark;
            mixed |= other.mixed;
        }
    };
    void findSeen()
    {
        seen_.resize(set_.size());
        forEachIndex(set_.size(), [&](std::size_t i) {
            for (std::size_t s = 0; s < sourceCount(); ++s) {
                const LitRange& range = first_[i * sourceCount() + s];
                const uint32_t bit = 1u << s;
                if (!range.any()) continue;
                seen_[i].notLit |= range.isLit() ? 0u : bit;
                seen_[i].notDark |= range.isDark() ? 0u : bit;
                seen_[i].mixed |= range.mixed() ? bit : 0u;
            }
        });
    }

    /// Marks texels whose neighbourhood disagrees. Texels next to one that an edge crosses get more rays, because their
    /// own rays easily miss the edge.
    void findOpen()
    {
        findSeen();
        open_.assign(pass_.texels.size() * sourceCount(), Closed);
        forEachIndex(pass_.texels.size(), [&](std::size_t i) {
            if (validPoints(i) != 0) findOpen(i);
        });
        release(seen_);
    }
    void findOpen(std::size_t i)
    {
        const uint32_t all = sourceCount() == kMaxShadowSources ? ~0u : (1u << sourceCount()) - 1u;
        uint32_t undecided = all;
        if (validPoints(i) == kAllPoints) {
            Seen together;
            int around = 0;
            pass_.grid.around(pass_.texels[i], kAgreeRadius, [&](uint32_t other) {
                together.add(seen_[set_.find(other)]);
                ++around;
            });
            if (around >= kEnoughTexels) undecided = disagreeing(i, together.notLit & together.notDark);
        }
        if (undecided == 0) return;
        Seen beside;
        pass_.grid.around(pass_.texels[i], 1, [&](uint32_t other) { beside.add(seen_[set_.find(other)]); });
        for (std::size_t s = 0; s < sourceCount(); ++s) {
            const uint32_t bit = 1u << s;
            if ((undecided & bit) != 0)
                open_[i * sourceCount() + s] = (beside.mixed & bit) != 0 ? BesideEdge : Undecided;
        }
    }
    /// Those of the sources of which the neighbourhood's rays disagree: rays through the same glass agree, too.
    [[nodiscard]] uint32_t disagreeing(std::size_t i, uint32_t sources) const
    {
        uint32_t result = 0;
        for (std::size_t s = 0; s < sourceCount(); ++s) {
            if ((sources >> s & 1u) == 0) continue;
            LitRange together;
            pass_.grid.around(pass_.texels[i], kAgreeRadius,
                              [&](uint32_t other) { together.add(first_[set_.find(other) * sourceCount() + s]); });
            result |= together.mixed() ? 1u << s : 0u;
        }
        return result;
    }

    /// Closes all but partly lit texels and those in a given state.
    void keepOpen(Open state)
    {
        forEachIndex(open_.size(), [&](std::size_t i) {
            if (!counts_[i].mixed() && open_[i] != state) open_[i] = Closed;
        });
    }

    /// Traces half-batches begin … end - 1 of the open texels.
    Status traceHalves(int begin, int end, const Progress& progress)
    {
        list_ = indicesWhere(pass_.texels.size(), [&](std::size_t i) {
            const auto first = open_.begin() + std::ptrdiff_t(i * sourceCount());
            return std::any_of(first, first + std::ptrdiff_t(sourceCount()), [](Open o) { return o != Closed; });
        });
        if (pass_.device != nullptr) return traceHalvesOnDevice(begin, end, progress);
        return forTexelGroups(
            pass_.paths.surfaces(), list_.size(), [&](std::size_t i) { return pass_.texels[list_[i]]; },
            [&](std::span<const uint32_t> texels) {
                return ShadowGroup(pass_.paths, pass_.map, texels, PointUse::Valid);
            },
            progress, pass_.stage, pass_.rays,
            [&] {
                return [&, begin, end](const ShadowGroup& group, std::size_t first, uint64_t& rays) {
                    traceHalves(group, first, begin, end, rays);
                };
            });
    }
    Status traceHalvesOnDevice(int begin, int end, const Progress& progress)
    {
        const auto isOpen = [&](std::size_t i, std::size_t s) { return open_[list_[i] * sourceCount() + s] != Closed; };
        const auto firstOf = [&](std::size_t i) { return begin + (isCounted(begin, validPoints(list_[i])) ? 1 : 0); };
        const auto countOf = [&](std::size_t i) {
            std::size_t open = 0;
            for (std::size_t s = 0; s < sourceCount(); ++s) open += isOpen(i, s) ? 1 : 0;
            return open * std::size_t(std::max(end - firstOf(i), 0));
        };
        const auto fill = [&](std::size_t i, std::span<DeviceShadows::Item> items) {
            auto item = items.begin();
            for (std::size_t s = 0; s < sourceCount(); ++s)
                for (int half = firstOf(i); isOpen(i, s) && half < end; ++half)
                    *item++ = {0, uint32_t(half), validPoints(list_[i]), uint16_t(s)};
        };
        const auto use = [&](std::size_t i, const BatchShadows::Sums& sums) {
            std::size_t item = 0;
            for (std::size_t s = 0; s < sourceCount(); ++s)
                for (int half = firstOf(i); isOpen(i, s) && half < end; ++half)
                    add(list_[i] * sourceCount() + s, sums, item++);
        };
        std::vector<uint32_t> texels(list_.size());
        for (std::size_t i = 0; i < texels.size(); ++i) texels[i] = pass_.texels[list_[i]];
        return BatchShadows(*pass_.device, pass_.map, sources_, !colors_.empty())
            .trace(texels, countOf, fill, use, progress, pass_.stage, pass_.rays);
    }
    /// traceFirst() has counted half-batch 0 of texels whose points are all valid.
    static bool isCounted(int half, PointMask points) { return half == 0 && points == kAllPoints; }

    /// `group` has batch 0 of the texels' points.
    void traceHalves(const ShadowGroup& group, std::size_t first, int begin, int end, uint64_t& rays)
    {
        const auto lanes = std::size_t(group.lanes());
        std::array<uint32_t, kLanes> texels;
        for (std::size_t lane = 0; lane < lanes; ++lane) texels[lane] = group.texel(int(lane));
        for (int half = begin; half < end; half += 2) {
            if (half == 0) {
                traceHalf(group, first, half, rays);
                traceHalf(group, first, half + 1, rays);
                continue;
            }
            const ShadowGroup points(pass_.paths, pass_.map, std::span(texels.data(), lanes), PointUse::Valid,
                                     half / 2);
            traceHalf(points, first, half, rays);
            traceHalf(points, first, half + 1, rays);
        }
    }
    void traceHalf(const ShadowGroup& points, std::size_t first, int half, uint64_t& rays)
    {
        const auto lanes = std::size_t(points.lanes());
        for (std::size_t s = 0; s < sourceCount(); ++s) {
            uint32_t wanted = 0;
            for (std::size_t lane = 0; lane < lanes; ++lane) {
                const bool open = open_[list_[first + lane] * sourceCount() + s] != Closed;
                wanted |= open && !isCounted(half, points.mask(int(lane))) ? 1u << lane : 0u;
            }
            if (wanted == 0) continue;
            const ShadowRays shadows(pass_.paths, pass_.pattern, sources_[s]);
            const ShadowRays::Sums sums = shadows.trace(points, wanted, half, rays);
            for (std::size_t lane = 0; lane < lanes; ++lane) add(list_[first + lane] * sourceCount() + s, sums, lane);
        }
    }

    /// Adds a lane's sums, or an item's, to those of a texel and source.
    template<typename Sums> void add(std::size_t place, const Sums& sums, std::size_t lane)
    {
        counts_[place].add(sums.lit[lane]);
        if (!colors_.empty()) colors_[place] += sums.colors[lane];
    }

    const ShadowPass& pass_;
    const std::vector<ShadowSource>& sources_;
    std::vector<LitSum>& counts_; ///< by texel of the pass and source
    std::vector<vec3>& colors_;   ///< the same, or empty
    TexelSet asked_;
    TexelSet set_;                ///< the pass's texels and their neighbours
    bool whole_;                  ///< both sets are the same
    std::vector<LitRange> first_; ///< by texel of the set and source
    std::vector<Seen> seen_;      ///< by texel of the set
    std::vector<Open> open_;      ///< by texel of the pass and source
    std::vector<uint32_t> list_;  ///< open texels of the pass
};

} // namespace

Status traceShadows(const ShadowPass& pass, const std::vector<ShadowSource>& sources, std::vector<LitSum>& counts,
                    std::vector<vec3>* colors)
{
    assert(sources.size() <= kMaxShadowSources);
    counts = largeVector<LitSum>(pass.texels.size() * sources.size());
    if (sources.empty()) return {};
    std::vector<vec3> none;
    if (colors != nullptr && pass.paths.surfaces().anyTinted())
        *colors = largeVector<vec3>(pass.texels.size() * sources.size());
    return ShadowTracer(pass, sources, counts, colors != nullptr ? *colors : none).trace();
}

/// Kernels without a device: here, because kernels know nothing of texels.
Result<std::unique_ptr<DeviceShadows>> RayKernels::prepareShadows(const ShadowTables& /*tables*/) const
{
    return std::unique_ptr<DeviceShadows>();
}

} // namespace halflight
