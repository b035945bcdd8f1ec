#include "unwrap/surface/triangle_tree.h"

#include <numeric>

namespace halflight::charts {

TriangleTree::TriangleTree(const std::vector<Corners>& triangles)
{
    boxes_.reserve(triangles.size());
    for (const Corners& corners : triangles) boxes_.push_back(boundsOf(corners));
    order_.resize(triangles.size());
    std::iota(order_.begin(), order_.end(), 0u);
    if (!triangles.empty()) build(0, uint32_t(triangles.size()));
}

uint32_t TriangleTree::build(uint32_t begin, uint32_t end)
{
    constexpr uint32_t kLeaf = 8;
    const auto number = uint32_t(nodes_.size());
    nodes_.emplace_back();
    Box box, centers;
    const auto centerOf = [&](uint32_t t) { return 0.5 * (boxes_[t].low + boxes_[t].high); };
    for (uint32_t i = begin; i < end; ++i) {
        box.extend(boxes_[order_[i]].low);
        box.extend(boxes_[order_[i]].high);
        centers.extend(centerOf(order_[i]));
    }
    nodes_[number].box = box;
    if (end - begin <= kLeaf) {
        nodes_[number].first = begin;
        nodes_[number].count = end - begin;
        return number;
    }
    const dvec3 size = centers.high - centers.low;
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const uint32_t middle = begin + (end - begin) / 2;
    std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                     [&](uint32_t a, uint32_t b) {
                         const double ca = centerOf(a)[axis], cb = centerOf(b)[axis];
                         return ca != cb ? ca < cb : a < b;
                     });
    const uint32_t first = build(begin, middle);
    const uint32_t second = build(middle, end);
    nodes_[number].first = first;
    nodes_[number].second = second;
    return number;
}

} // namespace halflight::charts
