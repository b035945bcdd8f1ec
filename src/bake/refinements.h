#pragma once
// Parts of the bake that `bench_bake ablate` switches off, to measure what each of them gains.

namespace halflight {

/// Each is on in a bake. Results without one are right too, but take longer to a given error, or should.
struct Refinements {
    // Sampling.
    bool lightTreeCut = true;
    bool lightTreeQuads = true;
    bool stratumShuffle = true;
    bool emitterRoulette = true;
    bool directionTables = true;
    // Final gather.
    bool prefetch = true;
    bool sourceShares = true;
    bool planDetail = true;
    bool planRims = true;
    bool planTrimmed = true;
    bool planMapMean = true;
    // Guides.
    bool guides = true;
    bool sharedGuides = true;
    bool widerGuides = true;
    bool unseenSources = true;
    // Radiosity.
    bool thinnedGather = true;
    bool splitNear = true;
    bool splitOccluded = true;
    bool halfTexels = true;
    // Shadows.
    bool firstBatches = true;
    bool foldBatches = true;
    bool besideEdges = true;
    // Validity.
    bool validityScouts = true;
    bool validityEarlyOut = true;
    // Denoiser.
    bool varianceScales = true;
    bool outliers = true;
    bool darkSpecks = true;
    bool varianceQuantiles = true;
    bool fittedTrend = true;
    bool slopes = true;
    bool pairedTaps = true;
    bool filteredDirect = true;
    bool sparseOutliers = true;
};

#ifdef HALFLIGHT_ABLATION
inline Refinements refinements; ///< the benchmark sets it between bakes
#else
inline constexpr Refinements refinements; ///< so that compilers remove the branches
#endif

} // namespace halflight
