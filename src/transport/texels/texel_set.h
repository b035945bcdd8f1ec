#pragma once
// Sorted subset of a lightmap's texels.

#include "halflight/bake/texel_grid.h"

#include <algorithm>
#include <span>
#include <vector>

namespace halflight {

/// Texels of a map in ascending order, with lookup of their positions in the set.
class TexelSet {
public:
    TexelSet(const TexelMap& map, std::span<const uint32_t> texels) : map_(map), texels_(texels.begin(), texels.end())
    {
        sort();
    }
    /// Calls others(texel, add) for each texel; add(other) adds a texel to the set.
    template<typename Others> void extend(const Others& others)
    {
        if (size() == map_.texels.size()) return;
        // In a contiguous set nearly all others are members already.
        for (std::size_t i = 0, count = texels_.size(); i < count; ++i) {
            others(texels_[i], [&](uint32_t other) {
                if (!inRun(other)) texels_.push_back(other);
            });
        }
        sort();
    }
    [[nodiscard]] std::size_t size() const { return texels_.size(); }
    [[nodiscard]] uint32_t operator[](std::size_t i) const { return texels_[i]; }
    [[nodiscard]] std::span<const uint32_t> texels() const { return texels_; }
    /// Position of a member.
    [[nodiscard]] std::size_t find(uint32_t texel) const
    {
        if (inRun(texel)) return run_.position + (texel - run_.texel);
        return std::size_t(std::lower_bound(texels_.begin(), texels_.end(), texel) - texels_.begin());
    }
    [[nodiscard]] bool contains(uint32_t texel) const
    {
        return inRun(texel) || std::binary_search(texels_.begin(), texels_.end(), texel);
    }

private:
    [[nodiscard]] bool inRun(uint32_t texel) const { return texel - run_.texel < run_.length; }
    void sort()
    {
        if (!std::is_sorted(texels_.begin(), texels_.end())) std::sort(texels_.begin(), texels_.end());
        texels_.erase(std::unique(texels_.begin(), texels_.end()), texels_.end());
        run_ = {};
        for (std::size_t first = 0, end = 0; first < texels_.size(); first = end) {
            for (end = first + 1; end < texels_.size() && texels_[end] == texels_[end - 1] + 1;) ++end;
            if (end - first > run_.length) run_ = {texels_[first], uint32_t(end - first), first};
        }
    }

    const TexelMap& map_;
    /// Longest run of consecutive texels. Positions in it need no search.
    struct Run {
        uint32_t texel = 0;
        uint32_t length = 0;
        std::size_t position = 0;
    };
    Run run_;
    std::vector<uint32_t> texels_;
};

} // namespace halflight
