#pragma once
// Discrete distributions sampled in constant time.

#include "halflight/shading/gather.h"

#include <cstdint>
#include <span>
#include <vector>

namespace halflight {

/// One bin of an alias table (Walker 1977, "An Efficient Method for Generating Discrete Random Variables with General
/// Distributions"). A table of n outcomes has n bins of probability 1/n; bin i holds outcome i and one alias.
struct AliasBin {
    float share = 1.0f;       ///< of the bin that is outcome i; the rest is the alias
    uint32_t aliasOffset = 0; ///< index of the alias minus i, modulo 2^32

    /// Offset of the outcome that a number in [0, 1) selects, which becomes a number in [0, 1) again.
    [[nodiscard]] uint32_t select(float& u) const { return shading::selectsOwn(share, u) ? 0 : aliasOffset; }
};

/// Fills the bins for outcomes whose probabilities sum to 1 (Vose 1991, "A Linear Algorithm for Generating Random
/// Numbers with a Given Distribution"). `probabilities` is overwritten.
inline void fillAliasTable(std::span<double> probabilities, std::span<AliasBin> bins)
{
    const auto count = double(bins.size());
    std::vector<uint32_t> low;
    std::vector<uint32_t> high;
    for (uint32_t i = 0; i < bins.size(); ++i) {
        bins[i] = {1.0f, 0};
        probabilities[i] *= count;
        (probabilities[i] < 1.0 ? low : high).push_back(i);
    }
    // A bin with less than 1/n is filled up from an outcome with more.
    while (!low.empty() && !high.empty()) {
        const uint32_t filled = low.back();
        const uint32_t alias = high.back();
        low.pop_back();
        bins[filled] = {float(probabilities[filled]), alias - filled};
        probabilities[alias] -= 1.0 - probabilities[filled];
        if (probabilities[alias] >= 1.0) continue;
        high.pop_back();
        low.push_back(alias);
    }
}

} // namespace halflight
