#pragma once
// Interpolated texels: which texels need no rays because traced ones surround them on a smooth surface.

#include "halflight/bake/texel_grid.h"

#include <array>

namespace halflight {

/// A map's texels in levels: a sparse grid several texels wide, the texels halfway between its points, and so on down
/// to every texel. A texel may be interpolated between texels of earlier levels that lie symmetrically around it on one
/// smooth, fully covered piece of surface: irradiance is linear there to second order (Ward, Rubinstein and Clear 1988,
/// "A Ray Tracing Solution for Diffuse Interreflection").
class SparseGrid {
public:
    /// `step`: width of the grid in texels, a power of two; 1 = all texels are of the first level. Geometry, map and
    /// grid outlive it.
    SparseGrid(const BakeGeometry& geometry, const TexelMap& map, const TexelGrid& grid, int step)
        : geometry_(geometry), map_(map), grid_(grid), step_(step)
    {}

    /// Distance in texels to the anchors of a texel; the step for texels of the first level, which have none.
    [[nodiscard]] int spacingOf(uint32_t texel) const;
    [[nodiscard]] int step() const { return step_; }
    /// Calls body(index) for the possible anchors of a texel on its chart.
    template<typename Body> void forNeighbours(uint32_t texel, const Body& body) const
    {
        const Offsets offsets = offsetsOf(texel);
        for (int i = 0; i < offsets.count; ++i) {
            const ivec2 offset = offsets.offset[std::size_t(i)];
            const uint32_t other = grid_.at(map_.texels[texel], offset.x, offset.y);
            if (other != kNoTexel) body(other);
        }
    }

    /// Texels that another one is interpolated between: two or four.
    struct Anchors {
        std::array<uint32_t, 4> texels{};
        int count = 0;
        float meters = 0.0f; ///< distance of the farthest
    };
    /// False for texels of the first level and where the surface around the texel is not smooth.
    bool anchorsOf(uint32_t texel, Anchors& out) const;

private:
    struct Center {
        vec3 position{0.0f};
        vec3 normal{0.0f};
    };
    struct Offsets {
        std::array<ivec2, 4> offset{};
        int count = 0;
    };
    [[nodiscard]] Offsets offsetsOf(uint32_t texel) const;
    /// Centre of a texel; false if the texel is not fully covered.
    bool centerOf(uint32_t texel, Center& out) const;

    const BakeGeometry& geometry_;
    const TexelMap& map_;
    const TexelGrid& grid_;
    int step_;
};

} // namespace halflight
