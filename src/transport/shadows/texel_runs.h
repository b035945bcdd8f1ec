#pragma once
// Which texels a light may reach.

#include "transport/sample/light_reach.h"

#include "halflight/bake/integrator.h"

#include <cstdint>
#include <span>
#include <vector>

namespace halflight {

/// Runs of 16 texels that are neighbours on the map, with their bounds.
class TexelRuns {
public:
    /// `texels` in ascending order.
    TexelRuns(const BakeGeometry& geometry, const TexelMap& map, std::span<const uint32_t> texels);

    [[nodiscard]] std::size_t size() const { return bounds_.size(); }
    [[nodiscard]] std::span<const Bounds> bounds() const { return bounds_; }
    /// Indices into the list of texels, in ascending order, of those of the runs that one of the lights may reach.
    [[nodiscard]] std::vector<uint32_t> reachedBy(std::span<const PunctualLight* const> lights, std::size_t firstRun,
                                                  std::size_t endRun) const;

    static constexpr std::size_t kTexels = 16; ///< of a run; in the map's order about 4 x 4 neighbours

private:
    std::vector<Bounds> bounds_;
    std::size_t count_ = 0; ///< of texels
};

} // namespace halflight
