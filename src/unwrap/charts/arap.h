#pragma once
// As-rigid-as-possible flattening: Liu, Zhang, Xu, Gotsman and Gortler 2008, "A Local/Global Approach to Mesh
// Parameterization".

#include "unwrap/charts/piece.h"

namespace halflight::charts {

/// Where each vertex lies, given where its corners would: their mean.
std::vector<dvec2> startingPoint(const Piece& piece, std::span<const dvec2> ofCorner);

/// Each triangle starts in the frame that the smallest rotation of its normal onto the mean normal gives it, so that a
/// piece of a cylinder or cone lies flat after the first global step. With a guess (3 corners per triangle) it starts
/// in the frame that fits that best.
std::vector<dvec2> relax(const Piece& piece, std::span<const dvec2> guess);

} // namespace halflight::charts
