#pragma once
// Final gather: the irradiance of texels from one ray per sample, which ends in the radiance cache.

#include "transport/lightmap/next_event.h"

namespace halflight {

class FinalGather {
public:
    /// `cache` and `guides` null = no bounces: rays receive emitters and sky alone.
    FinalGather(const PathTracer& paths, const StratifiedPattern& pattern, const RadianceCache* cache,
                const Guides* guides, const IntegrationSettings& settings)
        : paths_(paths), pattern_(pattern), cache_(cache), settings_(settings),
          block_(cache, paths.light().components()), next_(paths, pattern, cache, guides, settings)
    {}

    /// Estimates of a group's texels, by lane; those of components by lane and component, where there are some.
    struct Estimates {
        std::span<TexelEstimate> texels;
        std::span<ComponentEstimate> components;
    };
    /// Adds the given blocks of 16 samples to the group's texels.
    void add(const GatherGroup& group, int firstBlock, int blockCount, const Estimates& estimates, uint64_t& rays);

private:
    using Radiances = std::array<Vec3Lanes, StratifiedPattern::kBlock>;
    void gatherBlock(const GatherGroup& group, int number, uint64_t& rays);
    void tint(Radiances& radiance) const;
    void weightHits(const GatherGroup& group, int number, Radiances& radiance, uint64_t& rays);
    void sampleEmitters(const GatherGroup& group, int number, const Estimates& estimates, uint64_t& rays);
    void addEmission(std::size_t sample, vec3 radiance);
    void addComponents(const GatherGroup& group);
    [[nodiscard]] bool hasComponents() const { return block_.components.count() > 0; }
    /// A ray that hits an emitter, or goes on as a path.
    struct RayFrom {
        Receiver receiver;
        vec3 direction{0.0f};
        RayHit hit;
        uint32_t texelId = 0;
        uint32_t sample = 0; ///< number among all of the texel
    };
    [[nodiscard]] RayFrom rayOf(const GatherGroup& group, int lane, int number, int stratum) const;
    [[nodiscard]] vec3 emission(const RayFrom& ray) const;
    [[nodiscard]] vec3 continuation(const RayFrom& ray, uint64_t& rays);

    const PathTracer& paths_;
    const StratifiedPattern& pattern_;
    const RadianceCache* cache_;
    const IntegrationSettings& settings_;
    GatherBlock block_;
    NextEvent next_;
    PathLights lights_;                          ///< of the current continuation path
    std::array<float, kBlockSamples> weights_{}; ///< MIS weights of rays that hit patches, where there are components
};

} // namespace halflight
