#pragma once
// Final gather: the irradiance of texels from one ray per sample, which ends in the radiance cache.

#include "transport/lightmap/device_gather.h"
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
    /// Adds emitter samples to texels with gathered light: as many blocks as that has, from a first one on.
    void addEmitters(const GatherGroup& group, int firstBlock, const Estimates& estimates, uint64_t& rays);

    /// Blocks of a texel that a device has traced.
    struct TracedBlocks {
        int firstBlock = 0;
        std::size_t number = 0; ///< of the first one in the device's list
        std::span<const DeviceGather::Sums> sums;
        std::span<const DeviceGather::EmitterHit> emissive;
        std::span<const DeviceGather::Point> points;
        int pointCount = 0; ///< 0 = the texel is not traced
        uint32_t id = 0;    ///< texelId()
        TexelEstimate* estimate = nullptr;
    };
    /// Adds what rays receive of emitters, and then the blocks and their emitter samples to the estimates of up to
    /// eight texels.
    void finish(const TexelMap& map, std::span<const uint32_t> texels, std::span<const TracedBlocks> blocks,
                uint64_t& rays);

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
    void finish(const TracedBlocks& blocks, const LightTree::Cut* cut, std::size_t lane) const;

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
