#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

namespace halflight {

/// Disjoint sets of the numbers 0 … count - 1, each at first a set of its own (union–find with path halving; Tarjan and
/// van Leeuwen 1984, "Worst-case Analysis of Set Union Algorithms").
class DisjointSets {
public:
    explicit DisjointSets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0u); }

    /// The least number of the element's set, whatever the order in which sets were joined.
    uint32_t find(uint32_t element)
    {
        while (parent_[element] != element) {
            parent_[element] = parent_[parent_[element]];
            element = parent_[element];
        }
        return element;
    }

    void join(uint32_t a, uint32_t b)
    {
        a = find(a);
        b = find(b);
        parent_[std::max(a, b)] = std::min(a, b);
    }

    [[nodiscard]] std::size_t size() const { return parent_.size(); }

private:
    std::vector<uint32_t> parent_;
};

} // namespace halflight
