#pragma once
// The cells between the probes of a grid, halved as in an octree: around rooms, and along the edges of shadows.

#include "bake/probes/probe_placement.h"

#include "halflight/scene/baked_scene.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

namespace halflight {

/// Shortest side of the cells around rooms, metres. Storeys for people are higher than 2 m, so that cells halved until
/// they are shorter have a corner between each floor and its ceiling.
constexpr float kFinestMeters = 1.25f;

/// Cells on a lattice with a power of two of intervals along each side of a grid cell. An axis of a cell is halved
/// where its side is longer than half of the longest one, so that cells of flat grids become cubes.
class ProbeTree {
public:
    struct Cell {
        ivec3 low{0};
        ivec3 size{0};      ///< lattice intervals along each side, powers of two
        vec3 sides{0.0f};   ///< metres, of the cell that probes are placed by: at first its own
        float error = 0.0f; ///< largest error of interpolated occlusion, 0…1
    };
    struct Sample {
        MaskValues occlusion;
        bool valid = false;            ///< false: inside geometry
        std::optional<uint32_t> probe; ///< index of the probe at this lattice point, if any
    };

    /// `probes` are those of the grid, in its order. `grid` outlives the object.
    ProbeTree(const ProbeSet& grid, std::span<const Probe> probes);

    /// Shortest cells along the edges of shadows, metres: halved twice, or as small as those around rooms.
    [[nodiscard]] float finestMeters() const;
    /// Cells of the grid.
    [[nodiscard]] std::vector<Cell> gridCells() const;
    /// The number of the grid cell, in the order of gridCells(), that a point is in or nearest to.
    [[nodiscard]] std::size_t gridCellAt(vec3 position) const;
    [[nodiscard]] vec3 positionOf(ivec3 latticePoint) const;
    [[nodiscard]] vec3 sidesOf(const Cell& cell) const; ///< metres
    [[nodiscard]] Sample& at(ivec3 latticePoint) { return samples_[key(latticePoint)]; }
    /// Probes at the corners of a cell that are outside geometry.
    [[nodiscard]] std::vector<uint32_t> validCorners(const Cell& cell);

    /// Whether no half of a cell would be shorter than that along its longest side.
    [[nodiscard]] bool canHalve(const Cell& cell, float finestMeters) const;
    /// The 8, 4 or 2 parts of a cell.
    [[nodiscard]] std::vector<Cell> halves(const Cell& cell) const;
    /// Calls body(latticePoint, offset) for the corners of the halves of a cell, up to 27. Offsets from its low corner
    /// are in halves of its sides: 0, 1 or 2 along each axis.
    template<typename Body> void forPoints(const Cell& cell, const Body& body) const
    {
        const ivec3 step = stepsOf(cell);
        for (int k = 0; k < 27; ++k) {
            const ivec3 offset(k % 3, k / 3 % 3, k / 9);
            if (glm::any(glm::notEqual(offset % step, ivec3(0)))) continue;
            body(cell.low + offset * cell.size / 2, offset);
        }
    }
    /// Makes probes of those points of a cell that have none and are not known to be inside geometry, and links them.
    /// `first`: index of the first probe that is added.
    void addProbes(const Cell& cell, std::size_t first, AddedProbes& added);
    /// Occlusion and validity of the points of a cell that have a probe.
    void takeSamples(const Cell& cell, std::span<const Probe> probes);
    /// Links along the edges of cells, those that a smaller neighbour halves left out, in the order of their probes.
    [[nodiscard]] std::vector<ProbeLink> linksOf(std::span<const Cell> cells);

    /// Points of the halves of cells that have no sample, each once.
    [[nodiscard]] std::vector<ivec3> unsampledPoints(std::span<const Cell> cells) const;
    /// Keeps the cells whose occlusion, interpolated between their corners, is wrong by kDisagrees or more at one of
    /// the points of their halves, largest error first. All points need samples.
    void keepWrong(std::vector<Cell>& cells);

private:
    static uint64_t key(ivec3 latticePoint);
    /// By axis: 1 where the cell is halved, else 2.
    [[nodiscard]] ivec3 stepsOf(const Cell& cell) const;
    [[nodiscard]] float interpolationError(const Cell& cell, ivec3 offset, const Sample& truth);

    const ProbeSet& grid_;
    int side_ = 1; ///< lattice intervals along a side of a grid cell
    std::unordered_map<uint64_t, Sample> samples_;
};

} // namespace halflight
