#pragma once
// What is wrong with a flattening: folds and overlaps.

#include "unwrap/charts/piece.h"

#include <optional>
#include <utility>

namespace halflight::charts {

/// The triangle that folds worst, or kNone. Thin triangles count as folded when they lose nearly all their area.
uint32_t findFold(const Piece& piece, const std::vector<dvec2>& uv);

/// Lets vertices where triangles fold sink to the middle of their neighbours. What is marked once goes on sinking, so
/// that the patch which is free to move grows until nothing in it folds (Tutte 1963: at the least it lies flat once its
/// outline is convex). Borders stay.
void unfold(const Piece& piece, std::vector<dvec2>& uv);

/// A pair of triangles that overlap. Where nothing folds, a flattening overlaps itself only if its border does (the
/// number of sheets over a point is 0 far away and changes by one across a border), so only triangles at the border
/// are tested.
std::optional<std::pair<uint32_t, uint32_t>> findSelfOverlap(const Piece& piece, const std::vector<dvec2>& uv);

} // namespace halflight::charts
