#pragma once
// Texels that need not be traced: those that lie between traced ones where light hardly changes.

#include "halflight/bake/texel_grid.h"

#include <array>

namespace halflight {

/// A map's texels in levels: first those of a lattice several texels wide, then the ones halfway between these, and so
/// on down to every texel. A texel of one level may take the mean of those of the levels before that lie symmetrically
/// around it on the same smooth, fully covered piece of surface (irradiance is linear there to the second order:
/// Ward, Rubinstein and Clear 1988, "A Ray Tracing Solution for Diffuse Interreflection").
class SparseGrid {
public:
    /// `step`: width of the first lattice in texels, a power of two; 1 = all texels are of the first level. Geometry
    /// and map outlive the lattice, the grid too.
    SparseGrid(const BakeGeometry& geometry, const TexelMap& map, const TexelGrid& grid, int step)
        : geometry_(geometry), map_(map), grid_(grid), step_(step)
    {}

    /// Distance in texels to those that a texel may lie between; the step for texels of the first level, which lie
    /// between none.
    [[nodiscard]] int spacingOf(uint32_t texel) const;
    [[nodiscard]] int step() const { return step_; }
    /// Calls body(index) for those that a texel may lie between, of its chart.
    template<typename Body> void forNeighbours(uint32_t texel, const Body& body) const
    {
        const Offsets offsets = offsetsOf(texel);
        for (int i = 0; i < offsets.count; ++i) {
            const ivec2 offset = offsets.offset[std::size_t(i)];
            const uint32_t other = grid_.at(map_.texels[texel], offset.x, offset.y);
            if (other != kNoTexel) body(other);
        }
    }

    /// The texels that another lies between: two or four.
    struct Around {
        std::array<uint32_t, 4> texels{};
        int count = 0;
        float meters = 0.0f; ///< distance of the farthest
    };
    /// False where the texel is of the first level, or where the surface does not go on evenly around it.
    bool around(uint32_t texel, Around& out) const;

private:
    struct Middle {
        vec3 position{0.0f};
        vec3 normal{0.0f};
    };
    struct Offsets {
        std::array<ivec2, 4> offset{};
        int count = 0;
    };
    [[nodiscard]] Offsets offsetsOf(uint32_t texel) const;
    /// The middle of a texel that is covered all over.
    bool middleOf(uint32_t texel, Middle& out) const;

    const BakeGeometry& geometry_;
    const TexelMap& map_;
    const TexelGrid& grid_;
    int step_;
};

} // namespace halflight
