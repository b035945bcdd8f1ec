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
    /// The given texels and those within `radius` of them.
    TexelSet(const TexelGrid& grid, const TexelMap& map, std::span<const uint32_t> texels, int radius)
        : whole_(texels.size() >= map.texels.size()), texels_(texels.begin(), texels.end())
    {
        if (!whole_ && radius > 0) {
            for (const uint32_t texel : texels) {
                grid.around(texel, radius, [&](uint32_t other) { texels_.push_back(other); });
            }
        }
        std::sort(texels_.begin(), texels_.end());
        texels_.erase(std::unique(texels_.begin(), texels_.end()), texels_.end());
        whole_ = texels_.size() == map.texels.size();
    }
    [[nodiscard]] std::size_t size() const { return texels_.size(); }
    [[nodiscard]] uint32_t operator[](std::size_t i) const { return texels_[i]; }
    /// Of a texel that is in the set.
    [[nodiscard]] std::size_t find(uint32_t texel) const
    {
        if (whole_) return texel;
        return std::size_t(std::lower_bound(texels_.begin(), texels_.end(), texel) - texels_.begin());
    }

private:
    bool whole_;
    std::vector<uint32_t> texels_;
};

} // namespace halflight
