#pragma once
// The part of a bake that traces rays, with or without a cache.

#include "bake/cache.h"

namespace halflight {

/// Of the texels and of what decides how they are sampled: bakes that agree in it can be compared tile by tile.
Hash128 layoutHash(const TexelMap& map, const IntegrationSettings& settings, MixedLightingMode mode);

/// Of all that light does in a bake of that layout.
Hash128 lightHash(Hash128 layout, const Scene& scene, const BakeGeometry& geometry);

/// Integrator calls for all texels and probes. With a cache, tiles come from it where they can. All return false when
/// cancelled.
struct Gather {
    Integrator& integrator;
    const BakeGeometry& geometry;
    const TexelMap& map;
    IntegrationSettings settings;
    BakeCache* cache = nullptr; ///< may be null

    bool irradiance(std::span<IrradianceEstimate> out, const Progress& progress) const;
    /// `estimates` are those of irradiance().
    bool shadowmask(std::span<const IrradianceEstimate> estimates, std::span<vec4> out, const Progress& progress) const;
    /// `batch`: a bake may ask for several sets of probes, 0, 1, 2…, each kept by the cache for itself.
    bool probes(std::span<const vec3> positions, std::span<ProbeEstimate> out, int batch,
                const Progress& progress) const;
};

} // namespace halflight
