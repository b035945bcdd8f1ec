#pragma once
// Transmittance from texels to lights, for shadowmasks and for baked direct light.

#include "transport/shadows/device_shadows.h"

#include "halflight/bake/texel_grid.h"

#include <algorithm>
#include <atomic>
#include <span>
#include <vector>

namespace halflight {

/// Rays on shadow edges relative to the samples asked for. Masks are quantized to 1/255, baked light is not.
constexpr int kTimesOnMaskEdges = 2;
constexpr int kTimesOnLightEdges = 8;

struct ShadowPass {
    const PathTracer& paths;
    const StratifiedPattern& pattern;
    const TexelMap& map;
    const TexelGrid& grid;
    std::span<const uint32_t> texels; ///< in ascending order
    int samples;                      ///< rays per texel and source
    int timesOnEdges;                 ///< factor of `samples` on shadow edges
    const Progress& progress;
    const char* stage;
    std::atomic<uint64_t>& rays;
    const DeviceShadows* device = nullptr; ///< null: the processor traces

    /// The same of other texels, or with another share of the progress, which outlives it.
    [[nodiscard]] ShadowPass of(std::span<const uint32_t> others, const Progress& part) const
    {
        return {paths, pattern, map, grid, others, samples, timesOnEdges, part, stage, rays, device};
    }
    [[nodiscard]] ShadowPass withEdges(int times) const
    {
        return {paths, pattern, map, grid, texels, samples, times, progress, stage, rays, device};
    }
};

/// Traces 8 rays per texel and source. Where all rays within 3 texels agree, lit or shadowed, that is the result. The
/// other texels get half of `samples`, texels beside an edge all, and partly lit ones `timesOnEdges` times as many.
/// Counts are by texel and source.
/// `colors`, if given, gets the sums of weight times transmittance by colour, in scenes whose glass has one.
Status traceShadows(const ShadowPass& pass, const std::vector<ShadowSource>& sources, std::vector<LitSum>& counts,
                    std::vector<vec3>* colors = nullptr);

} // namespace halflight
