#pragma once
// Footprints as a packer tests and draws them.

#include "unwrap/pack/packer.h"

#include <vector>

namespace halflight::charts {

struct Run {
    int y, x, length;
};

/// A footprint as it is tested and drawn: runs of texels, and runs with the padding around (from -padding, -padding
/// on).
struct Shape {
    ivec2 size{0};
    int orientation = 0;
    std::vector<Run> texels;
    std::vector<Run> padded; ///< in the order of spreadOut()
    uint32_t number = 0;     ///< of all that have the same texels
};

/// Shapes of items in all orientations that they may have. Items with the same footprint share them.
class ShapeTable {
public:
    /// Shapes are missing when cancelled.
    ShapeTable(const std::vector<PackItem>& items, int padding, const Progress& progress);

    [[nodiscard]] const std::vector<Shape>& of(std::size_t item) const { return shapes_[kindOf_[item]]; }
    [[nodiscard]] std::size_t count() const { return count_; } ///< of different Shape::number

private:
    std::vector<std::vector<Shape>> shapes_; ///< by kind of item, each different one once
    std::vector<uint32_t> kindOf_;           ///< by item
    std::size_t count_ = 0;
};

} // namespace halflight::charts
