#pragma once
// Neighbours of texels on the lightmap.

#include "halflight/bake/integrator.h"
#include "halflight/base/image.h"
#include "halflight/base/parallel.h"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace halflight {

constexpr uint32_t kNoTexel = ~0u;

/// Index of the covered texel at each place of each page. The map outlives it.
class TexelGrid {
public:
    explicit TexelGrid(const TexelMap& map) : map_(map)
    {
        for (int p = 0; p < map.pageCount; ++p) pages_.emplace_back(map.pageSize, map.pageSize, kNoTexel);
        forEachIndex(map.texels.size(), [&](std::size_t i) {
            const Texel& t = map.texels[i];
            pages_[t.page](t.x, t.y) = uint32_t(i);
        });
    }

    /// Index of the texel at an offset in texels from another; kNoTexel if there is none on the same chart.
    [[nodiscard]] uint32_t at(const Texel& texel, int dx, int dy) const
    {
        const int x = int(texel.x) + dx;
        const int y = int(texel.y) + dy;
        if (x < 0 || y < 0 || x >= map_.pageSize || y >= map_.pageSize) return kNoTexel;
        const uint32_t other = pages_[texel.page](x, y);
        return other != kNoTexel && map_.texels[other].chart == texel.chart ? other : kNoTexel;
    }

    /// Index of the texel at a place on a page, in texels; kNoTexel if none is there.
    [[nodiscard]] uint32_t atPlace(uint32_t page, vec2 place) const
    {
        const ivec2 p(glm::floor(place));
        const bool outside = p.x < 0 || p.y < 0 || p.x >= map_.pageSize || p.y >= map_.pageSize;
        return outside ? kNoTexel : pages_[page](p.x, p.y);
    }

    /// Calls body(index) for each texel of the same chart at most `radius` texels away along both axes, and for the
    /// texel itself.
    template<typename Body> void around(uint32_t texel, int radius, const Body& body) const
    {
        for (int dy = -radius; dy <= radius; ++dy) {
            for (int dx = -radius; dx <= radius; ++dx) {
                const uint32_t other = at(map_.texels[texel], dx, dy);
                if (other != kNoTexel) body(other);
            }
        }
    }

private:
    const TexelMap& map_;
    std::vector<Image<uint32_t>> pages_;
};

} // namespace halflight
