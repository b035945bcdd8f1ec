#pragma once
// Cells of a probe grid in which a shadow edge passes, subdivided like an octree.

#include "halflight/scene/baked_scene.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

namespace halflight {

/// Difference of occlusion (0…1), or of irradiance over the larger of both, from which on two probes, or a probe and
/// its interpolation, disagree.
constexpr float kDisagrees = 0.35f;

/// Grid cells whose interpolated occlusion is wrong by kDisagrees or more. Coordinates are those of a lattice
/// with 2^kLevels intervals along each side of a grid cell.
class OcclusionCells {
public:
    static constexpr int kLevels = 2; ///< subdivisions of a grid cell

    struct Cell {
        ivec3 low{0};
        int size = 0;       ///< lattice intervals along a side, a power of two
        float error = 0.0f; ///< largest error of interpolation, 0…1
    };
    struct Sample {
        vec4 occlusion{1.0f};
        bool valid = false;            ///< false: inside geometry
        std::optional<uint32_t> probe; ///< index of the probe at this lattice point, if any
    };

    /// `probes` are those of the grid, in its order. `grid` outlives the object.
    OcclusionCells(const ProbeSet& grid, std::span<const Probe> probes);

    [[nodiscard]] const std::vector<Cell>& cells() const { return cells_; }
    [[nodiscard]] vec3 positionOf(ivec3 latticePoint) const;
    [[nodiscard]] Sample& at(ivec3 latticePoint);

    /// Calls body(latticePoint, offset) for the 27 points of a cell: corners, midpoints of edges and faces, the centre.
    /// Offsets are 0, 1 or 2 along each axis.
    template<typename Body> static void forPoints(const Cell& cell, const Body& body)
    {
        for (int k = 0; k < 27; ++k) {
            const ivec3 offset(k % 3, k / 3 % 3, k / 9);
            body(cell.low + offset * (cell.size / 2), offset);
        }
    }
    /// Points of the cells without a sample, each once.
    [[nodiscard]] std::vector<ivec3> unsampledPoints() const;
    /// Computes the cells' errors, drops cells with a small one, and sorts the rest by error, largest first. All points
    /// need samples.
    void estimateErrors();
    /// Replaces the cells by the octants of the first `count`. Cells of the finest level have none.
    void subdivide(std::size_t count);

private:
    [[nodiscard]] bool cornersDisagree(const Cell& cell);
    [[nodiscard]] vec4 interpolationError(const Cell& cell, ivec3 offset, const Sample& truth);

    const ProbeSet& grid_;
    std::unordered_map<uint64_t, Sample> samples_;
    std::vector<Cell> cells_;
};

} // namespace halflight
