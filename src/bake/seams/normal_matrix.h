#pragma once

#include "bake/seams/seam_parts.h"

#include <Eigen/SparseCore>
#include <span>

namespace halflight {

/// The lower half of a part's normal equations: of each pair of unknowns, the sum of both weights' products over the
/// part's terms, in their order; on the diagonal also `keep`, by unknown of the part.
Eigen::SparseMatrix<double> normalMatrix(const SeamParts::Part& part, std::span<const uint32_t> placeOf,
                                         std::span<const SeamTerm> terms, const Eigen::VectorXd& keep);

} // namespace halflight
