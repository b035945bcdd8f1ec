#pragma once

#include "unwrap/surface/surface.h"

#include <span>
#include <vector>

namespace halflight::charts {

/// A connected piece of surface with its flattening.
struct Chart {
    std::vector<uint32_t> triangles; ///< ascending, none degenerate
    std::vector<uint32_t> corners;   ///< 3 per triangle: index into uv
    std::vector<dvec2> uv; ///< metres; area equals the surface's; turned into its smallest rectangle, from (0, 0) on
    dvec2 size{0.0};       ///< of that rectangle
    double area = 0.0;     ///< on the surface
    double stretch = 1.0;  ///< area-weighted L2 stretch (Sander et al. 2001), >= 1
    double perimeter = 0.0;
};

/// A flattening, or the two triangles that must not stay in one chart.
struct Flattening {
    bool valid = false;
    Chart chart;
    uint32_t seedA = kNone, seedB = kNone; ///< triangles of the surface; set when not valid
    std::vector<dvec2> corners; ///< where they all would lie, three per triangle, when nothing folds but parts overlap
};

/// Where flattening starts from.
struct Start {
    std::vector<dvec2> corners; ///< where the three corners of each triangle will lie, roughly; empty = not known
    bool settled = false;       ///< it only remains to be seen whether they overlap
};

/// Flattens edge-connected triangles (ascending) without folds or overlaps, or says where to split. To know where to
/// start saves large charts much time.
Flattening flatten(const Surface& surface, std::vector<uint32_t> triangles, const Start& start = {});

} // namespace halflight::charts
