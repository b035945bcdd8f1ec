#pragma once
// Neighbours of texels on the surface, across the seams between charts and objects.

#include "bake/seams/seams.h"
#include "halflight/bake/texel_grid.h"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace halflight {

/// A TexelGrid that goes on beyond the border of a chart: where a seam joins the chart to another one, places beyond
/// the border are places on that one, as if both lay unfolded in one plane. The map outlives it.
class SurfaceGrid {
public:
    SurfaceGrid(const TexelMap& map, std::span<const SeamSample> seams);

    /// Texels that bilinear filtering at a place reads, with weights that add up to 1 at most.
    struct Footprint {
        std::array<uint32_t, 4> texels{};
        std::array<float, 4> weights{};
        std::size_t count = 0;
    };

    /// The texel at an offset in texels on the same chart; kNoTexel if there is none.
    [[nodiscard]] uint32_t onChart(uint32_t texel, int dx, int dy) const
    {
        return grid_.at(map_.texels[texel], dx, dy);
    }
    /// Calls body(index) for each texel of the same chart at most `radius` texels away along both axes, and for the
    /// texel itself.
    template<typename Body> void aroundOnChart(uint32_t texel, int radius, const Body& body) const
    {
        grid_.around(texel, radius, body);
    }
    /// What is at an offset where the texel's own chart has nothing; without texels where no seam leads there.
    [[nodiscard]] Footprint beyond(uint32_t texel, int dx, int dy) const;

    /// The texel at an offset, beyond seams the nearest; kNoTexel if there is none.
    [[nodiscard]] uint32_t at(uint32_t texel, int dx, int dy) const;
    /// Calls body(index) for each texel at most `radius` texels away along both axes, and for the texel itself.
    template<typename Body> void around(uint32_t texel, int radius, const Body& body) const
    {
        for (int dy = -radius; dy <= radius; ++dy) {
            for (int dx = -radius; dx <= radius; ++dx) {
                const uint32_t other = at(texel, dx, dy);
                if (other != kNoTexel) body(other);
            }
        }
    }

private:
    /// A seam sample seen from one of its sides.
    struct Crossing {
        uint32_t texel = kNoTexel;  ///< at the border, on this side
        uint32_t target = kNoTexel; ///< on the other side
        vec2 place{0.0f};           ///< on this side's page, texels
        vec2 outward{0.0f};
        vec2 targetPlace{0.0f};
        mat2 across{1.0f}; ///< offsets on the other side's page for offsets on this one's
    };
    /// A place on a page, and a texel of the chart that it lies on.
    struct ChartPlace {
        vec2 place{0.0f};
        uint32_t texel = kNoTexel;
    };

    static void dropCrowded(std::vector<Crossing>& crossings);
    void indexCrossings();
    [[nodiscard]] std::optional<ChartPlace> placeBeyond(uint32_t texel, int dx, int dy) const;
    [[nodiscard]] const Crossing* crossingNear(uint32_t texel, vec2 exit, vec2 to) const;

    const TexelMap& map_;
    TexelGrid grid_;
    std::vector<Crossing> crossings_;     ///< sorted by texel
    std::vector<uint32_t> firstCrossing_; ///< by texel, and one more
    /// By texel, bit i: texel i of the 3 × 3 around it, row by row, has crossings and lies on its chart.
    std::vector<uint16_t> crossingsAround_;
    std::vector<uint8_t> chartHasSeams_;
};

} // namespace halflight
