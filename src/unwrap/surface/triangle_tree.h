#pragma once
// A bounding volume hierarchy over triangles.

#include "unwrap/surface/surface.h"

#include <algorithm>
#include <array>

namespace halflight::charts {

/// A box along the axes.
struct Box {
    dvec3 low{1e300}, high{-1e300};

    void extend(dvec3 p)
    {
        low = glm::min(low, p);
        high = glm::max(high, p);
    }
    [[nodiscard]] bool overlaps(const Box& other) const
    {
        return glm::all(glm::lessThanEqual(low, other.high)) && glm::all(glm::greaterThanEqual(high, other.low));
    }
};

using Corners = std::array<dvec3, 3>;

inline Box boundsOf(const Corners& corners)
{
    Box box;
    for (const dvec3& corner : corners) box.extend(corner);
    return box;
}

/// Split at the median of the centroids along the longest axis.
class TriangleTree {
public:
    explicit TriangleTree(const std::vector<Corners>& triangles);

    /// Calls body(triangle) for each triangle whose box overlaps `box`.
    template<typename Body> void forOverlapping(const Box& box, const Body& body) const
    {
        std::array<uint32_t, 64> stack{};
        std::size_t depth = 0;
        if (!nodes_.empty()) stack[depth++] = 0;
        while (depth > 0) {
            const Node& node = nodes_[stack[--depth]];
            if (!node.box.overlaps(box)) continue;
            if (node.count == 0) {
                stack[depth++] = node.first;
                stack[depth++] = node.second;
                continue;
            }
            for (uint32_t i = node.first; i < node.first + node.count; ++i) {
                if (boxes_[order_[i]].overlaps(box)) body(order_[i]);
            }
        }
    }

private:
    struct Node {
        Box box;
        uint32_t first = 0; ///< of a leaf: index into order_; else a child
        uint32_t second = 0;
        uint32_t count = 0; ///< triangles of a leaf; 0: not a leaf
    };
    uint32_t build(uint32_t begin, uint32_t end);

    std::vector<Box> boxes_;
    std::vector<uint32_t> order_;
    std::vector<Node> nodes_;
};

} // namespace halflight::charts
