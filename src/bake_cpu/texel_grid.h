#pragma once
// Who lies beside whom on the lightmap.

#include "halflight/bake/integrator.h"
#include "halflight/base/image.h"

#include <algorithm>
#include <span>
#include <vector>

namespace halflight {

/// Covered texels by their place.
class TexelGrid {
public:
    explicit TexelGrid(const TexelMap& map)
        : map_(map), pages_(std::size_t(map.pageCount), Image<uint32_t>(map.pageSize, map.pageSize, ~0u))
    {
        for (std::size_t i = 0; i < map.texels.size(); ++i) {
            const Texel& t = map.texels[i];
            pages_[t.page](t.x, t.y) = uint32_t(i);
        }
    }

    /// Calls body(number) for each texel within `radius` on the same chart, the texel itself among them.
    template<typename Body> void around(uint32_t texel, int radius, const Body& body) const
    {
        const Texel& t = map_.texels[texel];
        const Image<uint32_t>& page = pages_[t.page];
        for (int y = std::max(int(t.y) - radius, 0); y <= std::min(int(t.y) + radius, map_.pageSize - 1); ++y) {
            for (int x = std::max(int(t.x) - radius, 0); x <= std::min(int(t.x) + radius, map_.pageSize - 1); ++x) {
                const uint32_t other = page(x, y);
                if (other != ~0u && map_.texels[other].chart == t.chart) body(other);
            }
        }
    }

private:
    const TexelMap& map_;
    std::vector<Image<uint32_t>> pages_;
};

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
