#pragma once
// Which of many lights reach a place: what a light costs follows from the texels within its range.

#include "bake_cpu/sample/lights.h"

#include "halflight/bake/integrator.h"

#include <cstdint>
#include <span>
#include <vector>

namespace halflight {

/// Whether a light has no range.
bool reachesEverywhere(const PunctualLight& light);

/// Of lights that never meet, such as those of one mask channel, the one that reaches a point: a tree of the boxes
/// around their ranges.
class LightReach {
public:
    LightReach() = default;
    /// The lights outlive it.
    explicit LightReach(std::vector<const PunctualLight*> lights);

    /// The first in the list's order that reaches the point; null where none does.
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
    std::vector<uint32_t> everywhere_; ///< numbers of lights without a range
    std::vector<uint32_t> items_;      ///< numbers of the others, by leaf
    std::vector<Node> nodes_;
};

/// Texels in runs that lie side by side on the map, with a box around each.
class TexelRuns {
public:
    /// `texels` in ascending order.
    TexelRuns(const BakeGeometry& geometry, const TexelMap& map, std::span<const uint32_t> texels);

    /// Places, in the list of texels, of all runs that one of the lights may reach, in ascending order.
    [[nodiscard]] std::vector<uint32_t> reachedBy(std::span<const PunctualLight* const> lights) const;

private:
    std::vector<Bounds> bounds_;
    std::size_t count_ = 0; ///< of texels
};

} // namespace halflight
