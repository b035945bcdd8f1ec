#pragma once
// Transmittance from texels to lights, for shadowmasks and for baked direct light.

#include "transport/shadows/shadow_rays.h"

#include "halflight/bake/texel_grid.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <span>
#include <vector>

namespace halflight {

/// Rays of one texel to one light in one word, because there is one for every pair. Sums are floats without their last
/// eight bits; of kMostRays rays, each of the last eight still counts within 1/30 of its weight.
struct LitCount {
    static constexpr int kMostRays = 1 << 16;
    uint64_t lit : 24 = 0; ///< as LitSum::lit
    uint64_t all : 24 = 0;
    uint64_t least : 8 = LitRange{}.least;
    uint64_t most : 8 = LitRange{}.most;

    void add(const LitSum& sum)
    {
        lit = shortened(lengthened(lit) + sum.lit);
        all = shortened(lengthened(all) + sum.all);
        LitRange both = range();
        both.add(sum.range);
        least = both.least;
        most = both.most;
    }
    [[nodiscard]] bool any() const { return all > 0; }
    [[nodiscard]] bool mixed() const { return range().mixed(); }
    [[nodiscard]] float share() const { return any() ? std::min(lengthened(lit) / lengthened(all), 1.0f) : 1.0f; }

private:
    [[nodiscard]] LitRange range() const { return {uint8_t(least), uint8_t(most)}; }
    static float lengthened(uint64_t bits) { return std::bit_cast<float>(uint32_t(bits) << 8); }
    static uint64_t shortened(float sum) { return (std::bit_cast<uint32_t>(sum) + 0x80u) >> 8; }
};
static_assert(sizeof(LitCount) == 8);

struct ShadowPass {
    const PathTracer& paths;
    const StratifiedPattern& pattern;
    const TexelMap& map;
    const TexelGrid& grid;
    std::span<const uint32_t> texels; ///< in ascending order
    int samples;                      ///< rays per texel and source
    int timesOnEdges;                 ///< factor of `samples` on shadow edges
    const Progress& progress;
    const char* stage;
    std::atomic<uint64_t>& rays;

    /// The same of other texels, or with another share of the progress, which outlives it.
    [[nodiscard]] ShadowPass of(std::span<const uint32_t> others, const Progress& part) const
    {
        return {paths, pattern, map, grid, others, samples, timesOnEdges, part, stage, rays};
    }
};

/// Traces 8 rays per texel and source. Where all rays within 3 texels agree, lit or shadowed, that is the result. The
/// other texels get half of `samples`, texels beside an edge all, and partly lit ones `timesOnEdges` times as many.
/// Counts are by texel and source.
constexpr std::size_t kMaxShadowSources = 32;
Status traceShadows(const ShadowPass& pass, const std::vector<ShadowSource>& sources, std::vector<LitCount>& counts);

} // namespace halflight
