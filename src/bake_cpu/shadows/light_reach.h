#pragma once
// Lights by range: which of many lights reach a point, and which texels a light may reach.

#include "bake_cpu/sample/lights.h"

#include "halflight/bake/integrator.h"

#include <cstdint>
#include <span>
#include <vector>

namespace halflight {

/// Whether a light has no range, so that it may reach every texel.
bool reachesEverywhere(const PunctualLight& light);

/// Bounding volume hierarchy over the ranges of lights of which at most one reaches any point, such as the lights of
/// one mask channel.
class LightReach {
public:
    LightReach() = default;
    /// The lights outlive it.
    explicit LightReach(std::vector<const PunctualLight*> lights);

    /// The first light in the list's order that reaches the point, or null.
    [[nodiscard]] const PunctualLight* at(vec3 point) const;
    [[nodiscard]] const std::vector<const PunctualLight*>& lights() const { return lights_; }

private:
    struct Node {
        Bounds bounds;
        uint32_t first = 0; ///< of items_; in an inner node, the right child (the left one follows the node)
        uint32_t count = 0; ///< of items_; 0 in an inner node
    };
    uint32_t build(uint32_t first, uint32_t end);

    std::vector<const PunctualLight*> lights_;
    std::vector<uint32_t> everywhere_; ///< indices of lights without a range
    std::vector<uint32_t> items_;      ///< indices of the others, by leaf
    std::vector<Node> nodes_;
};

/// Runs of 64 texels that are neighbours on the map, with their bounds.
class TexelRuns {
public:
    /// `texels` in ascending order.
    TexelRuns(const BakeGeometry& geometry, const TexelMap& map, std::span<const uint32_t> texels);

    /// Indices into the list of texels, in ascending order, of all runs that one of the lights may reach.
    [[nodiscard]] std::vector<uint32_t> reachedBy(std::span<const PunctualLight* const> lights) const;

private:
    std::vector<Bounds> bounds_;
    std::size_t count_ = 0; ///< of texels
};

} // namespace halflight
