#pragma once
// The lightmap by radiosity and final gather.

#include "bake/cache/store.h"
#include "transport/lightmap/lightmap_run.h"

#include <memory>

namespace halflight {

class CachedLightmap {
public:
    /// `paths` and `pattern` outlive it.
    CachedLightmap(const PathTracer& paths, const StratifiedPattern& pattern, const IntegrationSettings& settings)
        : paths_(paths), pattern_(pattern), settings_(settings)
    {}

    /// As Integrator::irradiance(), without fully baked lights. The first call for a map builds its radiance cache and
    /// guides. False when cancelled.
    bool irradiance(const TexelMap& map, std::span<const uint32_t> texels, int samples,
                    std::span<IrradianceEstimate> out, const Progress& progress, std::atomic<uint64_t>& rays);
    /// Builds the radiance cache and guides of a map, and the scale of its sample plan. False when cancelled, as the
    /// above.
    bool prepareAll(const TexelMap& map, const Progress& progress, std::atomic<uint64_t>& rays);
    /// As Integrator::shareIrradiance().
    bool shareParts(const TexelMap& map, const Progress& progress, std::atomic<uint64_t>& rays);
    /// As Integrator::keepIn().
    void keepIn(Store store) { store_ = store; }
    /// Frees the state of the map.
    void release() { state_.reset(); }

private:
    bool prepare(const TexelMap& map, const Progress& progress, std::atomic<uint64_t>& rays);
    bool build(LightmapState& state, const TexelMap& map, const Progress& progress, std::atomic<uint64_t>& rays) const;
    [[nodiscard]] float meanOf(const LightmapInput& input, std::atomic<uint64_t>& rays) const;
    bool findScale(const LightmapInput& input, const Progress& progress, std::atomic<uint64_t>& rays);
    bool findScaleTogether(const LightmapInput& input, std::span<const uint32_t> texels, const Progress& progress,
                           std::atomic<uint64_t>& rays);

    const PathTracer& paths_;
    const StratifiedPattern& pattern_;
    IntegrationSettings settings_;
    Store store_;
    std::unique_ptr<LightmapState> state_;
    const TexelMap* map_ = nullptr;
    std::size_t mapTexels_ = 0;
};

} // namespace halflight
