#pragma once
// How much of each light's disc the texels see: the rays of shadowmasks and of direct light that is baked.

#include "bake_cpu/gather_pattern.h"
#include "bake_cpu/path.h"
#include "bake_cpu/texel_group.h"

#include "halflight/bake/texel_grid.h"

#include <algorithm>
#include <atomic>
#include <functional>
#include <span>
#include <vector>

namespace halflight {

/// What a texel's rays to one light have told so far, in one word: the number of rays takes kAllBits.
template<typename Word, int kAllBits> struct LitCountIn {
    static constexpr int kMost = (1 << kAllBits) - 1; ///< rays that can be counted
    static constexpr int kLit = 254;                  ///< of a ray all of whose light arrives
    /// Rays that differ no more than this find the same: light through one pane of glass, say.
    static constexpr int kAlike = 8;
    Word lit : kAllBits + 8 = 0; ///< kLit for each ray, or what arrives of that
    Word all : kAllBits = 0;
    Word least : 8 = kLit;
    Word most : 8 = 0;

    /// A ray of whose light a share arrives.
    void add(float share)
    {
        const auto value = Word(share * float(kLit) + 0.5f);
        lit += value;
        ++all;
        least = std::min(Word(least), value);
        most = std::max(Word(most), value);
    }
    /// Takes in what another's rays found, but for their number and sum.
    void addRange(const LitCountIn& other)
    {
        least = std::min(Word(least), Word(other.least));
        most = std::max(Word(most), Word(other.most));
    }
    /// Whether rays found one thing and others another.
    [[nodiscard]] bool mixed() const { return int(most) - int(least) > kAlike; }
    [[nodiscard]] float share() const { return all > 0 ? float(Word(lit)) / float(kLit * int(all)) : 1.0f; }
};
using LitCount = LitCountIn<uint64_t, 16>;
/// Of the first few rays: half as large, since there is one for each texel and light at once.
using FirstLitCount = LitCountIn<uint32_t, 4>;

/// A light, or several that never meet.
struct ShadowSource {
    std::vector<const PunctualLight*> lights;
    bool lit = false; ///< only points that would be lit look: those that face the light, which is not dark there
    uint32_t seed = 0;

    /// The light that a point looks at, null for none.
    [[nodiscard]] const PunctualLight* lightAt(const SurfacePoint& point) const;
};

struct ShadowPass {
    const PathTracer& paths;
    const GatherPattern& pattern;
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
/// stands; the others get all of theirs. Counts are by texel of the pass and source. `look`, if any, is called for each
/// texel once its points are known: look(group, lane, number of the texel). At most kMaxShadowSources at once.
constexpr std::size_t kMaxShadowSources = 8;
bool traceShadows(const ShadowPass& pass, const std::vector<ShadowSource>& sources,
                  const std::function<void(const TexelGroup&, int, std::size_t)>& look, std::vector<LitCount>& counts);

} // namespace halflight
