#pragma once
// The lightmap by final gathering from the radiance cache, the same number of samples for all texels or as many as each
// needs; where light hardly changes, texels lie between traced ones.

#include "bake_cpu/lightmap/final_gather.h"
#include "bake_cpu/radiosity/radiance_cache.h"
#include "bake_cpu/texels/sparse_grid.h"
#include "bake_cpu/texels/texel_set.h"
#include "bake_cpu/texels/texel_validity.h"

#include <atomic>
#include <memory>
#include <optional>
#include <vector>

namespace halflight {

/// IntegrationSettings::texelStep, or what 0 comes to for a map: 1, 2 or 4.
int texelStepOf(const IntegrationSettings& settings, const TexelMap& map);

class CachedLightmap {
public:
    /// `paths` and `pattern` outlive it.
    CachedLightmap(const PathTracer& paths, const StratifiedPattern& pattern, const IntegrationSettings& settings)
        : paths_(paths), pattern_(pattern), settings_(settings), validity_(paths)
    {}

    /// As Integrator::irradiance(), without lights that are fully baked. The first call for a map fills its radiance
    /// cache. False when cancelled.
    bool irradiance(const TexelMap& map, std::span<const uint32_t> texels, int samples,
                    std::span<IrradianceEstimate> out, const Progress& progress, std::atomic<uint64_t>& rays);
    /// Forgets the map.
    void release() { state_.reset(); }

private:
    /// What is known of a texel while others still need it.
    struct Known {
        TexelLight light;
        PointMask mask = 0;
        bool active = false;
        bool between = false; ///< not traced, but the mean of others
    };
    /// First samples of some texels.
    struct FirstLook {
        TexelSet texels;
        std::vector<Known> known;
    };
    /// What is known of a whole map, whichever of its texels are asked for.
    struct MapState {
        TexelGrid grid;
        RadianceCache cache;
        ValidPoints outside;
        std::optional<FirstLook> looked; ///< by findShare()
        float share = 0.0f;              ///< what a texel's wish for samples is multiplied with; 0 = not known yet
    };
    class Run; // works on the texels asked for and on those they depend on
    bool findShare(const TexelMap& map, const Progress& progress, std::atomic<uint64_t>& rays);
    bool prepare(const TexelMap& map, const Progress& progress, std::atomic<uint64_t>& rays);
    [[nodiscard]] const RadianceCache* cache() const { return settings_.bounces > 0 ? &state_->cache : nullptr; }

    const PathTracer& paths_;
    const StratifiedPattern& pattern_;
    IntegrationSettings settings_;
    TexelValidity validity_;
    std::unique_ptr<MapState> state_;
    const TexelMap* map_ = nullptr;
    std::size_t mapTexels_ = 0;
    float mapMean_ = 0.0f;
};

} // namespace halflight
