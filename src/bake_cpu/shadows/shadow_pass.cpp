#include "bake_cpu/shadows/shadow_pass.h"

#include "bake_cpu/shadows/shadow_rays.h"
#include "bake_cpu/texels/texel_set.h"

#include "halflight/base/memory.h"

#include <algorithm>
#include <cassert>

namespace halflight {
namespace {

/// Texels within this distance have to agree: 49 x 8 rays, so that not even the rim of a penumbra is overlooked. Few
/// texels, of a small chart, are no evidence.
constexpr int kAgreeRadius = 3;
constexpr int kEnoughTexels = 16;
/// More rays, in pairs of halves, could not be counted.
constexpr int kMostHalves = LitCount::kMostRays / (2 * ShadowRays::kHalf) * 2;

} // namespace

bool traceShadows(const ShadowPass& pass, const std::vector<ShadowSource>& sources, std::vector<LitCount>& counts)
{
    const std::size_t sourceCount = sources.size();
    assert(sourceCount <= kMaxShadowSources);
    counts.assign(pass.texels.size() * sourceCount, {});
    if (sourceCount == 0) return true;

    // First look: all points of the texels and of their neighbours, asked for or not, inside geometry or not.
    const TexelSet asked(pass.map, pass.texels);
    TexelSet set = asked;
    set.extend([&](uint32_t texel, const auto& add) { pass.grid.around(texel, kAgreeRadius, add); });
    std::vector<LitRange> firstLook(set.size() * sourceCount);
    const bool whole = set.size() == asked.size();
    const auto isAsked = [&](uint32_t texel, std::size_t& number) {
        number = asked.find(texel);
        return whole || (number < asked.size() && asked[number] == texel);
    };
    if (!forTexelGroups<ShadowGroup>(
            pass.paths, pass.map, set.size(), [&](std::size_t i) { return set[i]; },
            [](std::size_t) { return kAllPoints; }, partOf(pass.progress, 0.0, 0.5), pass.stage, pass.rays,
            [&] {
                return [&](const TexelGroup& group, std::size_t first, uint64_t& rays) {
                    // Where points lie inside geometry the first look counts for nothing.
                    std::array<LitCount*, TexelGroup::kLanes> counted{};
                    for (int lane = 0; lane < group.lanes(); ++lane) {
                        std::size_t number = 0;
                        if (isAsked(group.texel(lane), number) && pass.outside[number] == kAllPoints)
                            counted[std::size_t(lane)] = &counts[number * sourceCount];
                    }
                    for (std::size_t s = 0; s < sourceCount; ++s) {
                        const ShadowRays shadows(pass.paths, pass.pattern, sources[s]);
                        const ShadowRays::Sums sums = shadows.trace(group, ~0u, 0, rays);
                        for (std::size_t lane = 0; lane < std::size_t(group.lanes()); ++lane) {
                            firstLook[(first + lane) * sourceCount + s] = sums[lane].range;
                            if (counted[lane] != nullptr) counted[lane][s].add(sums[lane]);
                        }
                    }
                };
            })) {
        return false;
    }

    // Beside a texel that an edge crosses, an edge is easily overlooked.
    enum Open : uint8_t { Closed, Undecided, BesideEdge };
    std::vector<Open> open(pass.texels.size() * sourceCount, Closed);
    parallelFor(pass.texels.size(), 4096, [&](std::size_t begin, std::size_t end) {
        std::array<LitRange, kMaxShadowSources> together; // of the texels around
        for (std::size_t i = begin; i < end; ++i) {
            if (pass.outside[i] == 0) continue;
            int around = 0;
            together.fill({});
            if (pass.outside[i] == kAllPoints) {
                pass.grid.around(pass.texels[i], kAgreeRadius, [&](uint32_t other) {
                    const LitRange* found = &firstLook[set.find(other) * sourceCount];
                    for (std::size_t s = 0; s < sourceCount; ++s) together[s].add(found[s]);
                    ++around;
                });
            }
            unsigned undecided = 0;
            for (std::size_t s = 0; s < sourceCount; ++s)
                undecided |= around < kEnoughTexels || together[s].mixed() ? 1u << s : 0u;
            if (undecided == 0) continue;
            unsigned mixed = 0;
            pass.grid.around(pass.texels[i], 1, [&](uint32_t other) {
                const LitRange* found = &firstLook[set.find(other) * sourceCount];
                for (std::size_t s = 0; s < sourceCount; ++s) mixed |= found[s].mixed() ? 1u << s : 0u;
            });
            for (std::size_t s = 0; s < sourceCount; ++s) {
                const unsigned bit = 1u << s;
                if ((undecided & bit) != 0) open[i * sourceCount + s] = (mixed & bit) != 0 ? BesideEdge : Undecided;
            }
        }
    });
    release(firstLook);
    // Three rounds: half of the rays for all that is open; the rest for what lies beside an edge or turns out to be
    // half lit; for what is half lit then, more.
    const int halves = ShadowRays::halvesOf(pass.samples);
    const int firstHalves = std::max(2, halves / 4 * 2);
    const int lastHalves = std::min(pass.timesOnEdges * halves, kMostHalves);
    const int nextHalves = std::min(2 * firstHalves, lastHalves);
    // What is half lit stays open, and what is in a given state.
    const auto keepOpen = [&](Open state) {
        for (std::size_t i = 0; i < open.size(); ++i) {
            if (!counts[i].mixed() && open[i] != state) open[i] = Closed;
        }
    };
    std::vector<uint32_t> list;
    const auto traceHalves = [&](int begin, int end, const Progress& progress) {
        list.clear();
        for (std::size_t i = 0; i < pass.texels.size(); ++i) {
            bool any = false;
            for (std::size_t s = 0; s < sourceCount; ++s) any = any || open[i * sourceCount + s] != Closed;
            if (any) list.push_back(uint32_t(i));
        }
        return forTexelGroups<ShadowGroup>(
            pass.paths, pass.map, list.size(), [&](std::size_t i) { return pass.texels[list[i]]; },
            [&](std::size_t i) { return pass.outside[list[i]]; }, progress, pass.stage, pass.rays,
            [&] {
                return [&](const TexelGroup& group, std::size_t first, uint64_t& rays) {
                    const auto lanes = std::size_t(group.lanes());
                    std::array<uint32_t, TexelGroup::kLanes> texels;
                    std::array<PointMask, TexelGroup::kLanes> masks;
                    // Texels all of whose points are in use have their first half.
                    uint32_t started = 0;
                    for (std::size_t lane = 0; lane < lanes; ++lane) {
                        texels[lane] = group.texel(int(lane));
                        masks[lane] = group.mask(int(lane));
                        started |= masks[lane] == kAllPoints ? 1u << lane : 0u;
                    }
                    const auto trace = [&](const TexelGroup& points, int half) {
                        for (std::size_t s = 0; s < sourceCount; ++s) {
                            uint32_t wanted = 0;
                            for (std::size_t lane = 0; lane < lanes; ++lane) {
                                wanted |= open[list[first + lane] * sourceCount + s] != Closed ? 1u << lane : 0u;
                            }
                            if (half == 0) wanted &= ~started;
                            if (wanted == 0) continue;
                            const ShadowRays shadows(pass.paths, pass.pattern, sources[s]);
                            const ShadowRays::Sums sums = shadows.trace(points, wanted, half, rays);
                            for (std::size_t lane = 0; lane < lanes; ++lane)
                                counts[list[first + lane] * sourceCount + s].add(sums[lane]);
                        }
                    };
                    // The group is of batch 0.
                    for (int half = begin; half < end; half += 2) {
                        const auto some = [&](const TexelGroup& points) {
                            trace(points, half);
                            trace(points, half + 1);
                        };
                        if (half == 0) {
                            some(group);
                        } else {
                            some(ShadowGroup(pass.paths, pass.map, std::span(texels.data(), lanes),
                                             std::span(masks.data(), lanes), half / 2));
                        }
                    }
                };
            });
    };
    if (!traceHalves(0, firstHalves, partOf(pass.progress, 0.5, 0.7))) return false;
    keepOpen(BesideEdge);
    if (!traceHalves(firstHalves, nextHalves, partOf(pass.progress, 0.7, 0.85))) return false;
    keepOpen(Closed);
    return traceHalves(nextHalves, lastHalves, partOf(pass.progress, 0.85, 1.0));
}

} // namespace halflight
