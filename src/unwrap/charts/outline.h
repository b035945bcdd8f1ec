#pragma once

#include "unwrap/surface/surface.h"

#include <span>

namespace halflight::charts {

/// Unit x axis of the rectangle of least area around the points. One of its sides lies on the convex hull
/// (Freeman and Shapira 1975), so it suffices to try the hull's edges.
dvec2 smallestRectangleAxis(std::span<const dvec2> points);

} // namespace halflight::charts
