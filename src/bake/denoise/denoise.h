#pragma once
// Parts of the built-in denoiser: what it filters, the noise it assumes, and outliers. denoise.cpp runs them.

#include "bake/seams/seams.h"
#include "bake/seams/surface_grid.h"

#include "halflight/bake/integrator.h"

#include <algorithm>
#include <array>
#include <span>
#include <vector>

namespace halflight {

/// True for a texel with samples of its own. An interpolated texel (CacheSettings::texelStep) is the mean of
/// traced ones, and carries no information beyond theirs.
inline bool isTraced(const IrradianceEstimate& estimate)
{
    return estimate.valid && estimate.samples > 0;
}
inline bool isInterpolated(const IrradianceEstimate& estimate)
{
    return estimate.valid && estimate.samples == 0;
}

/// One of the two terms of an estimate. The denoiser filters them separately: gathered light is noisy and smooth, the
/// direct light of fully baked lights has little noise and sharp edges.
struct NoisyLight {
    vec3 irradiance{0.0f}; ///< lux
    float variance = 0.0f; ///< of the luminance of `irradiance`, lux²
};
inline NoisyLight gatheredOf(const IrradianceEstimate& e)
{
    return {e.irradiance - e.direct, std::max(e.varianceOfMean - e.varianceOfDirect, 0.0f)};
}

/// One factor per texel, at most 1, by which the variance of gathered light is scaled before filtering. Estimates
/// derive their variance from half blocks of samples as if these were independent. Half blocks are stratified together,
/// so the stated variance is too large, by a factor that grows with the number of blocks.
std::vector<float> varianceScales(const SurfaceGrid& grid, std::span<const IrradianceEstimate> estimates);

/// Statistics of gathered light around one texel, on its surface: over the texels within a distance of 2 × `step` along
/// both axes (5 × 5 or 9 × 9), of a traced texel over traced ones alone. "Adjacent" is a distance of at most `step`.
struct NeighbourStats {
    static constexpr int kMaxCount = 80;
    int step = 1;                            ///< 1, or 2 where many texels are interpolated
    int count = 0;                           ///< neighbours, without the texel itself
    std::array<float, kMaxCount> luminances; ///< lux; the first `count` are set
    std::array<float, kMaxCount> variances;  ///< lux²; the first `count` are set
    int adjacentCount = 0;
    vec2 brightestAdjacent{0.0f};    ///< the two largest luminances of adjacent texels, descending
    vec2 darkestAdjacent{kInfinity}; ///< the two smallest, ascending
    vec3 irradianceSum{0.0f};        ///< over the neighbours
    float meanVariance = 0.0f;       ///< weighted, the texel itself included, each clamped to 4 × the texel's own
    float varianceWeight = 0.0f;     ///< sum of the weights; 0 without any valid texel
};

/// The texel that the statistics belong to.
struct OutlierTexel {
    float luminance = 0.0f;
    float variance = 0.0f;       ///< as scaled by varianceScales()
    float statedVariance = 0.0f; ///< as estimated by the integrator
    uint32_t samples = 0;
    bool isTraced = false;
    bool isWhole = false; ///< covered by more than kMostlyCovered, with no sample point inside geometry
};

NeighbourStats neighbourStats(const SurfaceGrid& grid, std::span<const IrradianceEstimate> estimates,
                              std::span<const NoisyLight> light, uint32_t texel, int step);

/// The variance that the filter uses for a texel, from its neighbourhood's.
float smoothedVariance(const NeighbourStats& stats, const OutlierTexel& texel);

/// The luminance of a texel after the removal of outliers: its own, the 7/8 quantile of its neighbourhood when the
/// texel is a firefly, the 1/8 quantile when it is a dark speck. `variance` is that of smoothedVariance().
float luminanceWithoutOutliers(const NeighbourStats& stats, const OutlierTexel& texel, float variance);

/// Applies the three functions above to all texels, in place. `moments` keep their directions.
void clampOutliers(const TexelMap& map, const SurfaceGrid& grid, std::span<const IrradianceEstimate> estimates,
                   std::vector<NoisyLight>& light, std::vector<vec3>& moments);

struct SeamSample;
/// Edge-avoiding à-trous filter on the surface: within charts, and across their `seams` (denoise.cpp). Position, normal
/// and variance guide it. `directions`: also filters first moments, for directional lightmaps.
void denoise(const BakeGeometry& geometry, const TexelMap& map, std::span<const SeamSample> seams,
             std::vector<IrradianceEstimate>& estimates, bool directions = true);

} // namespace halflight
