#pragma once
// Integrator calls of a bake, with or without the tile cache.

#include "bake/cache/cache.h"

namespace halflight {

/// Hash of the texels and the sampling settings: bakes with equal layouts are comparable tile by tile.
Hash128 layoutHash(const TexelMap& map, const IntegrationSettings& settings, MixedLightingMode mode);

/// Hash of all inputs that affect light in a bake of that layout.
Hash128 lightHash(Hash128 layout, const Scene& scene, const BakeGeometry& geometry);

/// The stage of a mask layer, as the cache names its parts.
std::string maskStage(int layer);

/// Integrator calls for all texels and probes; with a cache, only for tiles that it does not hold. All return false
/// when cancelled.
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

    bool irradiance(std::span<IrradianceEstimate> out, const Progress& progress) const;
    bool shadowmask(int layer, std::span<vec4> out, const Progress& progress) const;
    /// Some parts of the texels, by the cache, which is there.
    bool irradianceOfParts(std::span<const std::size_t> parts, std::span<IrradianceEstimate> out,
                           const Progress& progress) const;
    /// Has some parts of the texels in the cache, which is there.
    bool fillIrradiance(std::span<const std::size_t> parts, const Progress& progress) const;
    /// The same of all mask layers.
    bool fillShadowmasks(int layers, std::span<const std::size_t> parts, const Progress& progress) const;
    /// `batch`: number of the set of probes, 0, 1, 2…; the cache stores each set separately.
    bool probes(std::span<const vec3> positions, std::span<ProbeEstimate> out, int batch,
                const Progress& progress) const;

private:
    [[nodiscard]] BakeCache::Work<IrradianceEstimate, float> irradianceWork() const;
    [[nodiscard]] BakeCache::Work<vec4, vec4> shadowmaskWork(int layer) const;
};

} // namespace halflight
