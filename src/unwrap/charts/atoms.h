#pragma once

#include "halflight/base/progress.h"
#include "unwrap/surface/surface.h"

namespace halflight::charts {

/// Connected groups of up to `mostTriangles` that are all but flat and end at creases. kNone for degenerate triangles.
struct Atoms {
    std::vector<uint32_t> ofTriangle;
    uint32_t count = 0;
};

/// Joins in rounds what is each other's best neighbour, on all threads: clusterTriangles() takes the one best pair of
/// all at a time, which is too slow for millions of triangles.
Atoms gatherAtoms(const Surface& surface, uint32_t mostTriangles, const Progress& progress);

} // namespace halflight::charts
