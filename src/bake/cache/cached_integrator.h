#pragma once
// Integrator calls of a bake, with or without the tile cache.

#include "bake/cache/cache.h"
#include "bake/denoise/component_signals.h"

namespace halflight {

/// Hash of the texels, the sampling settings and the members of light groups: bakes with equal layouts are comparable
/// tile by tile.
Hash128 layoutHash(const TexelMap& map, const IntegrationSettings& settings, MixedLightingMode mode,
                   const Scene& scene);

/// Hash of all inputs that affect light in a bake of that layout.
Hash128 lightHash(Hash128 layout, const Scene& scene, const BakeGeometry& geometry);

/// The stage of a mask layer, as the cache names its parts.
std::string maskStage(int layer);

/// Integrator calls for all texels and probes; with a cache, only for tiles that it does not hold.
struct CachedIntegrator {
    Integrator& integrator;
    const BakeGeometry& geometry;
    const TexelMap& map;
    IntegrationSettings settings;
    BakeCache* cache = nullptr; ///< may be null
    /// By texel, in a bake of some objects: 1 = computed, 0 = kept. Empty otherwise.
    std::span<const uint8_t> chosen = {};
    /// In a bake of some objects: masks of all others are kept, and the probes' light and masks.
    bool keepsMasks = true;

    /// Integrator::prepare() for the map, with the cache's folder of parts.
    [[nodiscard]] std::unique_ptr<PreparedLightmap> prepare() const;
    Status irradiance(PreparedLightmap& lightmap, std::span<IrradianceEstimate> out, const Progress& progress) const;
    /// PreparedLightmap::irradianceByComponent() of all texels.
    Status irradianceByComponent(PreparedLightmap& lightmap, std::span<IrradianceEstimate> out,
                                 ComponentSignals& components, const Progress& progress) const;
    Status shadowmask(int layer, std::span<vec4> out, const Progress& progress) const;
    /// The same of some parts of the texels, by the cache, which is there; of all without parts. `components`: empty in
    /// a bake without groups.
    Status irradianceOfParts(PreparedLightmap& lightmap, std::span<const std::size_t> parts,
                             std::span<IrradianceEstimate> out, ComponentSignals& components,
                             const Progress& progress) const;
    /// Has some parts of the texels in the cache, which is there.
    Status fillIrradiance(PreparedLightmap& lightmap, std::span<const std::size_t> parts,
                          const Progress& progress) const;
    /// The same of all mask layers.
    Status fillShadowmasks(int layers, std::span<const std::size_t> parts, const Progress& progress) const;
    /// `batch`: number of the set of probes, 0, 1, 2…; the cache stores each set separately.
    Status probes(std::span<const vec3> positions, std::span<ProbeEstimate> out, int batch,
                  const Progress& progress) const;
    /// The same by Integrator::probesByComponent(). Without `components` they are not computed.
    Status probesByComponent(std::span<const vec3> positions, std::span<ProbeEstimate> out,
                             std::span<SphericalHarmonicsL2> components, int batch, const Progress& progress) const;

private:
    [[nodiscard]] std::size_t componentCount() const { return std::size_t(settings.components.count); }
    /// Of each texel of a request, the estimate of all light, and then those of the components.
    Status estimatesOf(PreparedLightmap& lightmap, const TexelRequest& request, std::span<IrradianceEstimate> out,
                       const Progress& progress) const;
    /// The same of probes: of components the radiance alone.
    Status estimatesOf(std::span<const vec3> positions, std::span<const uint32_t> which, int samples,
                       std::size_t components, std::span<ProbeEstimate> out, const Progress& progress) const;
    [[nodiscard]] BakeCache::Work<IrradianceEstimate, float> irradianceWork(PreparedLightmap& lightmap) const;
    [[nodiscard]] BakeCache::Work<vec4, vec4> shadowmaskWork(int layer) const;
};

} // namespace halflight
