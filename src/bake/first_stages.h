#pragma once
// The stages before any light is computed: from a scene to texels, geometry and an integrator.

#include "bake/cache/cached_integrator.h"
#include "bake/report/bake_report.h"

#include "halflight/bake/bake.h"
#include "halflight/base/file_group.h"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace halflight {

class LiveLight;

/// What all stages share.
struct BakeRun {
    const BakeSettings& settings;
    const Progress& progress;
    BakeResult& result;
    LiveLight* live = nullptr;       ///< of a bake in the background
    FileGroup* images = nullptr;     ///< of BakeSettings::imagesDirectory
    LightComponents components = {}; ///< of bakes with light groups

    [[nodiscard]] BakedScene& baked() const { return result.baked; }
    [[nodiscard]] BakeReport& report() const { return result.report; }
    /// Keeps the first error of image files, which do not end a bake.
    void noteImages(const Status& status) const
    {
        if (result.images && !status) result.images = status;
    }
};

/// How a bake uses BakeSettings::cacheDirectory.
struct CacheUse {
    /// Tiles of the last bake are reused where the change does not affect them, which takes check samples.
    bool compares = true;
    /// Of a farm's worker. Such a bake also keeps the texels.
    std::optional<WorkShare> share;
};

/// Results of the first stages. Its members refer to one another, so it is filled in place.
struct FirstStages {
    FirstStages() = default;
    FirstStages(const FirstStages&) = delete;
    FirstStages& operator=(const FirstStages&) = delete;

    IntegrationSettings integration;
    std::filesystem::path cacheFolder; ///< of the identity; empty without a cache
    BakeGeometry geometry;
    TexelMap map;
    std::vector<uint8_t> chosen; ///< texels of a bake of some objects, CachedIntegrator::chosen
    bool keepsMasks = true;      ///< CachedIntegrator::keepsMasks
    std::optional<BakeCache> cache;
    std::vector<std::string> notes; ///< moveFoldersAway() of all folders of parts
    std::unique_ptr<Integrator> integrator;

    [[nodiscard]] CachedIntegrator cached()
    {
        return {*integrator, geometry, map, integration, cache ? &*cache : nullptr, chosen, keepsMasks};
    }
};

/// Unwraps, assigns channels, builds geometry and integrator, rasterizes texels. The scene moves into the result. With
/// a cache, results of an earlier bake of the same scene are taken.
Status prepareTexels(const BakeRun& run, Scene scene, const IntegratorFactory& factory, const CacheUse& use,
                     FirstStages& firstStages);
Status validityStage(const BakeRun& run, FirstStages& firstStages);

/// Whether the bake has a mask to compute: a shadowmask, or that of subtractive's main light.
bool hasMask(const Scene& scene, MixedLightingMode mode);

} // namespace halflight
