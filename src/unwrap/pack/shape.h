#pragma once
// Footprints as a packer tests and draws them.

#include "halflight/base/hash.h"
#include "unwrap/pack/packer.h"

#include <span>
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
    Hash128 hash;            ///< of both
};

/// The shapes of an item in those orientations, each different one once.
std::vector<Shape> shapesOf(const PackItem& item, int padding, std::span<const int> orientations);

} // namespace halflight::charts
