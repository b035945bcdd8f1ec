#pragma once

#include "halflight/base/progress.h"
#include "unwrap/surface/surface.h"

namespace halflight::charts {

/// A surface drawn with far fewer triangles: each nearly flat group of them, an atom, is a fan around its centroid,
/// whose rim follows the atom's outline roughly. Which charts to join is found out on this; the charts are then sets of
/// whole atoms.
struct CoarseSurface {
    Surface surface;
    std::vector<uint32_t> atomOfTriangle; ///< by triangle of the fine surface; kNone for degenerate ones
    std::vector<uint32_t> fanStart;       ///< by atom: its first triangle in `surface`; one more at the end
};

CoarseSurface coarsen(const Surface& fine, const Progress& progress);

} // namespace halflight::charts
