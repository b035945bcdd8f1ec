#pragma once
// How many samples each texel takes: from the variance of its first samples and of its neighbours'.

#include "transport/lightmap/block_sums.h"
#include "transport/texels/texel_set.h"

#include "halflight/bake/texel_grid.h"

#include <span>
#include <vector>

namespace halflight {

struct TexelState {
    TexelEstimate estimate;
    bool valid = false;
};
/// Texels with their states.
struct TexelStates {
    TexelSet texels;
    std::vector<TexelState> states;
    std::vector<ComponentEstimate> components; ///< by texel and component; empty where light is estimated as one

    [[nodiscard]] const TexelState& of(uint32_t texel) const { return states[texels.find(texel)]; }
};

/// Samples that a texel takes, relative to the samples asked for, before the scale.
struct TexelDemand {
    uint32_t texel = 0;
    float times = 0.0f;
};

/// Without a noise target, a texel's samples are in proportion to the standard deviation of one (Neyman allocation:
/// Neyman 1934, "On the Two Different Aspects of the Representative Method"). Their mean over the map is the number
/// asked for. With a target, they take as many as the target needs.
class SamplePlan {
public:
    /// `samples` per texel; `scale` = samples of a texel per unit of demand; 0 = all texels take the same number.
    SamplePlan(const IntegrationSettings& settings, const BakeGeometry& geometry, const TexelMap& map,
               const TexelGrid& grid, float mapMean, int samples, float scale);

    /// Width of the neighbourhood that the plan reads: texels within this distance.
    static constexpr int kRadius = 2;
    static constexpr int kAround = (2 * kRadius + 1) * (2 * kRadius + 1);
    [[nodiscard]] int firstBlocks() const;
    /// Number of blocks at which texels with `blocks` are extended next.
    [[nodiscard]] int nextStep(int blocks) const { return std::min(blocks + std::max(1, blocks / 2), mostBlocks()); }
    /// The first step with at least `needed` blocks, from `blocks` on.
    [[nodiscard]] int blocksAtLeast(int blocks, int needed) const
    {
        while (blocks < needed) blocks = nextStep(blocks);
        return blocks;
    }
    [[nodiscard]] bool hasTarget() const { return settings_.cache.noiseTarget > 0.0f; }
    /// Blocks of a texel, once it and its neighbours have their first ones.
    [[nodiscard]] int blocksOf(uint32_t texel, const TexelStates& states) const
    {
        return hasTarget() ? blocksForTarget(texel, states) : blocksForDemand(texel, states);
    }
    /// Demands of the valid texels of `wanted`, in ascending order of texels.
    [[nodiscard]] std::vector<TexelDemand> demands(const TexelSet& wanted, const TexelStates& states) const;
    /// The scale with which texels of some demands take the samples asked for on average.
    [[nodiscard]] float scaleOf(std::span<const TexelDemand> demands) const;

private:
    /// Statistics of the first samples in a 5 x 5 neighbourhood, of luminance. Half-blocks are taken as independent,
    /// which overestimates the variance of stratified samples.
    struct Noise {
        float variance = 0.0f; ///< of a half-block
        float trimmed = 0.0f;  ///< of a half-block: trimmed mean over the least noisy 80 % of the texels
        float mean = 0.0f;
        int texels = 0;                 ///< in the neighbourhood, valid or not
        float meanInverseSquare = 0.0f; ///< of the gather rays' lengths, 1 / m^2
    };
    [[nodiscard]] Noise noiseAround(uint32_t texel, const TexelStates& states) const;
    [[nodiscard]] int mostBlocks() const;
    [[nodiscard]] float clampBlocks(float times) const;
    [[nodiscard]] float demand(uint32_t texel, const TexelStates& states) const;
    [[nodiscard]] float detail(uint32_t texel, const Noise& noise) const;
    [[nodiscard]] int blocksForDemand(uint32_t texel, const TexelStates& states) const;
    [[nodiscard]] int blocksForTarget(uint32_t texel, const TexelStates& states) const;

    const IntegrationSettings& settings_;
    const BakeGeometry& geometry_;
    const TexelMap& map_;
    const TexelGrid& grid_;
    float mapMean_; ///< luminance
    float blocks_;  ///< per texel
    float scale_;
};

} // namespace halflight
