#pragma once
// Sets of triangles cut into smaller ones, where a set makes no chart.

#include "unwrap/surface/surface.h"

namespace halflight::charts {

/// Splits a set of triangles in two, each grown from its seed over common edges. Pieces may be disconnected.
std::array<std::vector<uint32_t>, 2> splitTriangles(const Surface& surface, const std::vector<uint32_t>& triangles,
                                                    uint32_t seedA, uint32_t seedB);

/// The edge-connected pieces of a set of triangles, each ascending.
std::vector<std::vector<uint32_t>> connectedPieces(const Surface& surface, const std::vector<uint32_t>& triangles);

} // namespace halflight::charts
