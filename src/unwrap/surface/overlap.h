#pragma once

#include "unwrap/surface/surface.h"

#include <optional>
#include <span>
#include <utility>

namespace halflight::charts {

/// Triangles in the plane, three corners each.
struct FlatTriangle {
    dvec2 corners[3];
};

/// Two triangles whose interiors overlap by more than `tolerance` (a length), or nothing. Winding does not matter.
std::optional<std::pair<uint32_t, uint32_t>> findOverlap(std::span<const FlatTriangle> triangles, double tolerance);

} // namespace halflight::charts
