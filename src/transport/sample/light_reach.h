#pragma once
// Lights by range: which of many lights reach a point.

#include "transport/sample/lights.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace halflight {

/// Whether a light has no range, so that it may reach every texel.
bool reachesEverywhere(const PunctualLight& light);

/// Metres that a light reaches, with a margin for rounding errors: a light gives nothing beyond its range.
float reachOf(const PunctualLight& light);
/// Whether a light may reach a point of a box.
bool mayReach(const PunctualLight& light, const Bounds& box);

/// Bounding volume hierarchy over the ranges of lights.
class LightReach {
public:
    LightReach() = default;
    /// The lights outlive it.
    explicit LightReach(std::vector<const PunctualLight*> lights);

    /// Calls visit(number) for the lights without a range, and for those whose bounds contain the point.
    template<typename Visit> void each(vec3 point, Visit visit) const;

    /// The lights that may reach a point of some box, neighbours near one another.
    [[nodiscard]] std::vector<const PunctualLight*> near(std::span<const Bounds> boxes) const;
    [[nodiscard]] bool mayReach(const Bounds& box) const;

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
    template<typename Visit> void each(std::span<const Bounds> boxes, Visit visit) const;

    std::vector<const PunctualLight*> lights_;
    std::vector<uint32_t> everywhere_; ///< indices of lights without a range
    std::vector<uint32_t> items_;      ///< indices of the others, by leaf
    std::vector<Node> nodes_;
};

template<typename Visit> void LightReach::each(vec3 point, Visit visit) const
{
    Bounds box;
    box.extend(point);
    each(std::span(&box, 1), visit);
}

template<typename Visit> void LightReach::each(std::span<const Bounds> boxes, Visit visit) const
{
    for (const uint32_t number : everywhere_) visit(number);
    std::array<uint32_t, 64> stack;
    std::size_t depth = 0;
    if (!nodes_.empty()) stack[depth++] = 0;
    while (depth > 0) {
        const uint32_t index = stack[--depth];
        const Node& node = nodes_[index];
        const bool overlaps = std::any_of(boxes.begin(), boxes.end(), [&](const Bounds& box) {
            return glm::all(glm::lessThanEqual(node.bounds.min, box.max)) &&
                   glm::all(glm::lessThanEqual(box.min, node.bounds.max));
        });
        if (!overlaps) continue;
        for (uint32_t i = 0; i < node.count; ++i) visit(items_[node.first + i]);
        if (node.count > 0) continue;
        stack[depth++] = node.first;
        stack[depth++] = index + 1;
    }
}

} // namespace halflight
