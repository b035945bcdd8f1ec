#pragma once
// Lays footprints down on pages so that none comes closer to another than the padding.

#include "halflight/base/progress.h"
#include "unwrap/surface/footprint.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace halflight::charts {

/// What is to be laid down.
struct PackItem {
    const Footprint* footprint = nullptr;
    uint32_t group = 0;  ///< items of a group land on one page
    bool mayTurn = true; ///< in any of the eight orientations
};

struct Placement {
    int page = -1;
    ivec2 at{0}; ///< texel of the laid down footprint's corner
    int orientation = 0;
};

/// A rectangle with everything on it.
struct Block {
    ivec2 size{0}; ///< of what is used, from the corner
    std::vector<Placement> placements;
};

/// Lays everything down on one page of width × height, row by row from the top. Nothing when it does not fit, or
/// cancelled.
std::optional<Block> packOnePage(const std::vector<PackItem>& items, ivec2 pageSize, int padding,
                                 const Progress& progress);

/// Uses as many pages as it takes. Items of a group that does not fit on a page of its own keep page -1.
std::vector<Placement> packPages(const std::vector<PackItem>& items, ivec2 pageSize, int padding,
                                 const Progress& progress);

/// Lays everything down, in the orientation it has, on a rectangle that is about square and as small as it gets, but
/// not larger than `most` on a side. Empty when that is impossible.
std::optional<Block> packBlock(const std::vector<PackItem>& items, ivec2 most, int padding, const Progress& progress);

} // namespace halflight::charts
