#pragma once
// Neighbours of texels on the surface, across the seams between charts and objects.

#include "bake/seams/seams.h"
#include "bake/seams/surface_walk.h"
#include "halflight/bake/texel_grid.h"

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace halflight {

/// A TexelGrid that goes on beyond the border of a chart: where a seam joins the chart to another one, places beyond
/// the border are places on that one, as if both lay unfolded in one plane. The map outlives it.
class SurfaceGrid {
public:
    SurfaceGrid(const TexelMap& map, std::span<const SeamSample> seams);

    using Crossing = shading::SeamCrossing;

    /// What surface_walk.h needs, whose functions find texels.
    friend ivec2 placeOfTexel(const SurfaceGrid& grid, uint32_t texel)
    {
        return {grid.map_.texels[texel].x, grid.map_.texels[texel].y};
    }
    friend uint32_t texelAt(const SurfaceGrid& grid, uint32_t texel, ivec2 place)
    {
        return grid.grid_.onChart(grid.map_.texels[texel], place.x, place.y);
    }
    friend bool chartHasSeams(const SurfaceGrid& grid, uint32_t texel)
    {
        return grid.chartHasSeams_[grid.map_.texels[texel].chart] != 0;
    }
    friend uint32_t crossingsAround(const SurfaceGrid& grid, uint32_t texel) { return grid.crossingsAround_[texel]; }
    friend uint32_t firstCrossing(const SurfaceGrid& grid, uint32_t texel) { return grid.firstCrossing_[texel]; }
    friend const Crossing& crossingAt(const SurfaceGrid& grid, uint32_t crossing) { return grid.crossings_[crossing]; }

    [[nodiscard]] std::span<const TexelGrid::Cell> cells() const { return grid_.cells(); }
    [[nodiscard]] std::span<const Crossing> crossings() const { return crossings_; }
    [[nodiscard]] std::span<const uint32_t> firstCrossings() const { return firstCrossing_; }

private:
    [[nodiscard]] std::pair<Crossing, Crossing> crossingsOf(const SeamSample& seam) const;
    static void dropCrowded(std::vector<Crossing>& crossings);
    void indexCrossings();

    const TexelMap& map_;
    TexelGrid grid_;
    std::vector<Crossing> crossings_;     ///< sorted by texel
    std::vector<uint32_t> firstCrossing_; ///< by texel, and one more
    /// By texel, bit i: texel i of the 3 × 3 around it, row by row, has crossings and lies on its chart.
    std::vector<uint16_t> crossingsAround_;
    std::vector<uint8_t> chartHasSeams_;
};

} // namespace halflight
