#pragma once

#include "halflight/base/progress.h"
#include "unwrap/surface/surface.h"

#include <span>

namespace halflight::charts {

/// First guess at the charts: for each triangle the number of its region, 0…regionCount-1; kNone for degenerate ones.
/// Regions are connected, nearly flat, and end at creases.
struct Regions {
    std::vector<uint32_t> ofTriangle;
    uint32_t count = 0;
};

/// Merges triangles into regions bottom-up, cheapest merge first, after Garland, Willmott and Heckbert 2001,
/// "Hierarchical Face Clustering on Polygonal Surfaces"; the cost counts lost flatness, bent borders and ragged
/// outlines. `together` may name for each triangle the first of a connected set (itself, for that one) that is to stay
/// in one piece.
Regions clusterTriangles(const Surface& surface, std::span<const uint32_t> together, const Progress& progress = {});

} // namespace halflight::charts
