#pragma once
// The lightmap by radiosity and final gather.

#include "bake/cache/store.h"
#include "transport/lightmap/lightmap_run.h"

#include <memory>

namespace halflight {

/// As PreparedLightmap, without fully baked lights.
class CachedLightmap {
public:
    /// `paths`, `pattern` and `map` outlive it. `store` keeps what all texels have in common.
    CachedLightmap(const PathTracer& paths, const StratifiedPattern& pattern, const IntegrationSettings& settings,
                   const TexelMap& map, Store store)
        : paths_(paths), pattern_(pattern), settings_(settings), map_(map), store_(store)
    {}

    /// `components` is empty, or as of PreparedLightmap::irradianceByComponent().
    Status irradiance(std::span<const uint32_t> texels, int samples, std::span<IrradianceEstimate> out,
                      std::span<IrradianceEstimate> components, const Progress& progress, std::atomic<uint64_t>& rays);
    /// The radiance cache, the guides, and the scale of the sample plan.
    Status prepareAll(const Progress& progress, std::atomic<uint64_t>& rays);
    Status prepareParts(const Progress& progress, std::atomic<uint64_t>& rays) const;
    /// The settings have another number of samples. Texels that are estimated from now on take it. False: what they
    /// have in common is computed anew.
    bool samplesChanged(int before);

private:
    Status prepare(const Progress& progress, std::atomic<uint64_t>& rays);
    Status build(LightmapState& state, const Progress& progress, std::atomic<uint64_t>& rays) const;
    Status buildCache(LightmapState& state, const Progress& progress, std::atomic<uint64_t>& rays) const;
    [[nodiscard]] LightmapInput input() const { return {paths_, pattern_, settings_, map_, *state_}; }
    [[nodiscard]] float meanOf(const LightmapInput& input, std::atomic<uint64_t>& rays) const;
    Status findScale(const Progress& progress, std::atomic<uint64_t>& rays);
    Status findScaleTogether(const LightmapInput& input, std::span<const uint32_t> texels, const Progress& progress,
                             std::atomic<uint64_t>& rays);

    const PathTracer& paths_;
    const StratifiedPattern& pattern_;
    const IntegrationSettings& settings_;
    const TexelMap& map_;
    Store store_;
    std::unique_ptr<LightmapState> state_; ///< null until it is needed
};

} // namespace halflight
