#pragma once
// Next-event estimation of the final gather: samples of emitters and of secondary sources.

#include "transport/guiding/guides.h"
#include "transport/lightmap/hit_lookup.h"
#include "transport/sample/emitters.h"

#include <span>

namespace halflight {

/// Of samples, combined with the bake's seed: of emitters and the sky, of how many a block has, of secondary sources.
inline constexpr uint32_t kEmitterSeed = 0x5eed0006u;
inline constexpr uint32_t kRouletteSeed = 0x5eed0007u;
inline constexpr uint32_t kSourceSeed = 0x5eed0008u;

/// Samples of a guide's sources in a block: in proportion to the standard deviation that the rays would have due to
/// them (Neyman allocation), in powers of two from a quarter of the block on. With components, the most are three
/// quarters: the noisiest decides in nearly all places, and may have twice the noise of its own bake (spec S33).
int sourceSamplesOf(const Guide& guide, bool hasComponents);

/// Rays, sums and lookups of the block that is being gathered.
struct GatherBlock {
    GatherBlock(const RadianceCache* cache, int count) : components(count), hits(cache) {}
    RayBundle bundle;
    BlockSums sums;
    ComponentSums components;
    HitLookup hits;
};

/// Samples lights from the origins of a block's gather rays.
class NextEvent {
public:
    /// `guides` null = no secondary sources.
    NextEvent(const PathTracer& paths, const StratifiedPattern& pattern, const RadianceCache* cache,
              const Guides* guides, const IntegrationSettings& settings)
        : paths_(paths), pattern_(pattern), cache_(cache), guides_(guides), settings_(settings)
    {}

    /// Opens the light tree for a group's texels.
    void prepareEmitters(const GatherGroup& group);
    /// Finds the guides of a group's texels, and how many samples of a block each takes.
    void prepareSources(const GatherGroup& group);
    [[nodiscard]] bool samplesSources() const;
    [[nodiscard]] bool samplesSources(std::size_t lane) const { return sourceSamples_[lane] > 0; }

    [[nodiscard]] bool isSource(PatchId patch) const { return guides_->clusters().contains(patch); }

    /// The receiver of a gather ray, for the MIS weight of emitters that it hits.
    [[nodiscard]] Receiver receiverOf(const GatherGroup& group, int lane, int block, int stratum) const
    {
        const GatherGroup::Origin& s = group.origin(lane, group.pointOf(lane, block, stratum));
        return {s.position, s.normal, &cut_, std::size_t(lane)};
    }
    /// MIS weight of a ray that hits a secondary source.
    [[nodiscard]] float misWeightOfHit(const RayBundle& bundle, int stratum, int lane, PatchId patch) const;

    void sampleSources(const GatherGroup& group, int number, GatherBlock& block, uint64_t& rays);
    /// Samples emitters and the sky's bright part. Russian roulette per block: where they give little beside
    /// `estimates`, only some strata are sampled. All lanes drop the same strata first, so the remaining rays fill
    /// packets. `components`: by lane and component, where there are some.
    void sampleEmitters(const GatherGroup& group, int number, GatherBlock& block,
                        std::span<const TexelEstimate> estimates, std::span<const ComponentEstimate> components,
                        uint64_t& rays);
    /// Whether sampleEmitters() sampled a lane.
    [[nodiscard]] bool sampledEmitters(int lane) const { return emitterLanes_[std::size_t(lane)]; }

private:
    [[nodiscard]] bool samplesSource(std::size_t lane, int block, int stratum) const
    {
        return shading::takesSourceSample(sourceSamples_[lane], block, stratum);
    }
    [[nodiscard]] float sourceFraction(std::size_t lane) const
    {
        return float(sourceSamples_[lane]) / float(StratifiedPattern::kBlock);
    }
    [[nodiscard]] float besideEmitters(const TexelEstimate& estimate,
                                       std::span<const ComponentEstimate> components) const;
    void chooseSources(const GatherGroup& group, int number, std::span<const uint8_t> strata);
    void setSky(const GatherBlock& block, std::size_t stratum, const LightTree::Cut::Lanes<bool>& sky,
                const Vec2Lanes& u, EmitterLanes& lanes) const;
    void setSource(std::size_t sample, const GatherBlock& block, EmitterLanes& lanes);
    template<typename Choose>
    void addSamples(std::span<const uint8_t> strata, const Choose& choose, GatherBlock& block, uint64_t& rays);
    void addSamples(std::size_t stratum, const EmitterLanes& lanes, GatherBlock& block, uint64_t& rays);
    void addComponents(std::size_t stratum, std::size_t lane, const EmitterLanes& lanes, vec3 share, vec3 direction,
                       GatherBlock& block) const;

    const PathTracer& paths_;
    const StratifiedPattern& pattern_;
    const RadianceCache* cache_;
    const Guides* guides_;
    const IntegrationSettings& settings_;
    LightTree::Cut cut_;
    std::array<bool, kLanes> emitterLanes_{};
    std::array<Guide, kLanes> guide_;
    std::array<int, kLanes> sourceSamples_{}; ///< of a block
    std::array<SourcePoint, kBlockSamples> points_;
    /// Radiance in the cache of the sources that are sampled, by lane; only with components.
    std::array<const PatchRadiance*, kLanes> sourceRadiance_{};
    bool ofSources_ = false; ///< samples are of secondary sources, else of emitters and the sky
};

} // namespace halflight
