#pragma once
// Neighbours of texels on the lightmap.

#include "halflight/bake/integrator.h"
#include "halflight/base/memory.h"
#include "halflight/base/parallel.h"

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace halflight {

constexpr uint32_t kNoTexel = ~0u;

/// Index and chart of the covered texel at each place of each page. The map outlives it.
class TexelGrid {
public:
    explicit TexelGrid(const TexelMap& map) : map_(map), size_(map.pageSize)
    {
        cells_ = largeVector<Cell>(std::size_t(map.pageCount) * std::size_t(size_) * std::size_t(size_));
        forEachIndex(map.texels.size(), [&](std::size_t i) {
            const Texel& t = map.texels[i];
            cells_[indexOf(t.page, t.x, t.y)] = {uint32_t(i), t.chart};
        });
    }

    /// Index of the texel at an offset in texels from another; kNoTexel if there is none on the same chart.
    [[nodiscard]] uint32_t at(const Texel& texel, int dx, int dy) const
    {
        return onChart(texel, int(texel.x) + dx, int(texel.y) + dy);
    }

    /// Index of the texel at a place on a page, in texels; kNoTexel if none is there.
    [[nodiscard]] uint32_t atPlace(uint32_t page, vec2 place) const
    {
        const ivec2 p(glm::floor(place));
        return isOnPage(p.x, p.y) ? cells_[indexOf(page, p.x, p.y)].texel : kNoTexel;
    }
    /// Index of the texel at a place on the page of another texel; kNoTexel if there is none on the same chart.
    [[nodiscard]] uint32_t onChart(const Texel& texel, int x, int y) const
    {
        if (!isOnPage(x, y)) return kNoTexel;
        const Cell& cell = cells_[indexOf(texel.page, x, y)];
        return cell.chart == texel.chart ? cell.texel : kNoTexel;
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

    /// What is at a place of a page.
    struct Cell {
        uint32_t texel = kNoTexel;
        uint32_t chart = ~0u;
    };
    [[nodiscard]] std::span<const Cell> cells() const { return cells_; }

private:
    [[nodiscard]] bool isOnPage(int x, int y) const { return x >= 0 && y >= 0 && x < size_ && y < size_; }
    [[nodiscard]] std::size_t indexOf(uint32_t page, int x, int y) const
    {
        return (std::size_t(page) * std::size_t(size_) + std::size_t(y)) * std::size_t(size_) + std::size_t(x);
    }

    const TexelMap& map_;
    int size_ = 0;            ///< of a page, texels
    std::vector<Cell> cells_; ///< by page, row and column
};

} // namespace halflight
