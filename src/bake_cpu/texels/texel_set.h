#pragma once
// Some of a lightmap's texels.

#include "halflight/bake/texel_grid.h"

#include <algorithm>
#include <span>
#include <vector>

namespace halflight {

/// Some texels of a map, in ascending order, and where each is among them.
class TexelSet {
public:
    TexelSet(const TexelMap& map, std::span<const uint32_t> texels) : map_(map), texels_(texels.begin(), texels.end())
    {
        sort();
    }
    /// Adds for each texel those that `others(texel, add)` calls add() with.
    template<typename Others> void extend(const Others& others)
    {
        if (size() == map_.texels.size()) return;
        // Nearly all of them are in the set already where it is a piece of the map.
        for (std::size_t i = 0, count = texels_.size(); i < count; ++i) {
            others(texels_[i], [&](uint32_t other) {
                if (!inRun(other)) texels_.push_back(other);
            });
        }
        sort();
    }
    [[nodiscard]] std::size_t size() const { return texels_.size(); }
    [[nodiscard]] uint32_t operator[](std::size_t i) const { return texels_[i]; }
    /// Of a texel that is in the set.
    [[nodiscard]] std::size_t find(uint32_t texel) const
    {
        if (inRun(texel)) return run_.place + (texel - run_.texel);
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
        std::sort(texels_.begin(), texels_.end());
        texels_.erase(std::unique(texels_.begin(), texels_.end()), texels_.end());
        run_ = {};
        for (std::size_t first = 0, end = 0; first < texels_.size(); first = end) {
            for (end = first + 1; end < texels_.size() && texels_[end] == texels_[end - 1] + 1;) ++end;
            if (end - first > run_.length) run_ = {texels_[first], uint32_t(end - first), first};
        }
    }

    const TexelMap& map_;
    /// The longest run of texels one after the other: where these are need not be searched for.
    struct Run {
        uint32_t texel = 0;
        uint32_t length = 0;
        std::size_t place = 0;
    };
    Run run_;
    std::vector<uint32_t> texels_;
};

} // namespace halflight
