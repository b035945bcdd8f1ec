#pragma once
// What a bake shows of itself while it runs (BakeSession). The bake calls the first functions from its own thread.

#include "bake/cache/cached_integrator.h"
#include "bake/live/live_pages.h"
#include "bake/texels/texel_order.h"

#include "halflight/bake/bake_session.h"
#include "halflight/scene/light_groups.h"

#include <atomic>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

namespace halflight {

class LiveLight {
public:
    /// Before all others, in a bake with light groups: it shows them as the scene had them, though they are baked in
    /// white. `factory` outlives the calls.
    void setGroups(const LightGrouping& grouping, const IntegratorFactory& factory);
    /// The light of probes alone, of a scene without its layout.
    Status beginWithProbes(Scene scene, const BakeSettings& settings, const IntegratorFactory& factory,
                           const IntegrationSettings& integration, const Progress& progress);
    /// First light of a scene with its layout. `map`, which outlives the calls, has no valid points yet.
    Status begin(const BakedScene& scene, const CachedIntegrator& cached, const Progress& progress);
    /// As CachedIntegrator::irradianceByComponent(), piece by piece in the order of the view. `components`: empty
    /// without groups.
    Status irradiance(const CachedIntegrator& cached, PreparedLightmap& lightmap, std::span<IrradianceEstimate> out,
                      ComponentSignals& components, const Progress& progress);
    /// The finished pages, lux; of groups those of their white light.
    void finish(const std::vector<ImageRgb32f>& pages, const std::vector<std::vector<ImageRgb32f>>& groups);

    void setView(const BakeView& view);
    /// beginWithProbes() returns when this is false again, or when cancelled.
    void setWaits(bool waits);
    std::optional<BakedScene> takeProbeLight();
    std::optional<BakedScene> takeLight();
    std::vector<LightTile> takeTiles();

private:
    void show(const TexelMap& map, std::span<const uint32_t> texels, std::span<const IrradianceEstimate> all,
              const ComponentSignals& components);
    /// Gives the scene its own light in place of white groups.
    void takeOwnLight(Scene& scene) const;
    /// Light of a few texels, without a radiance cache.
    Status roughIrradiance(const Scene& own, const CachedIntegrator& cached, std::span<const uint32_t> texels,
                           std::vector<vec3>& light, const Progress& progress) const;
    [[nodiscard]] std::optional<BakeView> view() const;

    mutable std::mutex mutex_; ///< guards what follows
    std::optional<BakeView> view_;
    std::optional<LivePages> pages_;
    std::optional<BakedScene> probeLight_;
    std::optional<BakedScene> light_;
    float unitLux_ = 1.0f;
    bool taken_ = false; ///< the first light was
    const TexelMap* map_ = nullptr;
    std::atomic<bool> waits_ = false;            ///< not guarded
    ProbeSet probes_;                            ///< not guarded: the bake's own, for both lights
    std::optional<LightGrouping> grouping_;      ///< not guarded; with the scene's own light
    std::vector<vec3> factors_;                  ///< not guarded; of groups' white light in the scene's own
    const IntegratorFactory* factory_ = nullptr; ///< not guarded; of bakes with groups
};

/// bake(), shown by `live`.
Result<BakeResult> bake(Scene scene, const BakeSettings& settings, const IntegratorFactory& integratorFactory,
                        const Progress& progress, LiveLight* live);

} // namespace halflight
