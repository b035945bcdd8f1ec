#pragma once
// How much of each light's disc the texels see: the rays of shadowmasks and of direct light that is baked.

#include "bake_cpu/sample/path_tracer.h"
#include "bake_cpu/sample/stratified_pattern.h"
#include "bake_cpu/shadows/shadow_rays.h"
#include "bake_cpu/texels/ray_bundle.h"

#include "halflight/bake/texel_grid.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <span>
#include <vector>

namespace halflight {

/// What a texel's rays to one light have told so far, in one word: there is one for each texel and light at once. Sums
/// are floats without their last eight bits; of kMostRays, the last eight still count within a thirtieth of what they
/// should.
struct LitCount {
    static constexpr int kMostRays = 1 << 16;
    uint64_t lit : 24 = 0; ///< of `all`, what arrives
    uint64_t all : 24 = 0; ///< weights of the rays
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
    std::span<const uint32_t> texels;   ///< in ascending order
    std::span<const PointMask> outside; ///< of each of these
    int samples;                        ///< rays per texel and source
    int timesOnEdges; ///< so many times these where a shadow's edge is: few texels, and what one sees of a shadow
    const Progress& progress;
    const char* stage;
    std::atomic<uint64_t>& rays;
};

/// Rays to lights, few at first: where all of a texel's and its neighbours' rays agree, lit or shadowed, the answer
/// stands; the others get all of theirs. Counts are by texel of the pass and source. At most kMaxShadowSources at once.
constexpr std::size_t kMaxShadowSources = 8;
bool traceShadows(const ShadowPass& pass, const std::vector<ShadowSource>& sources, std::vector<LitCount>& counts);

} // namespace halflight
