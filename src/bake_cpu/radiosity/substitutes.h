#pragma once
// Replacements for patches without samples.

#include "bake_cpu/radiosity/patches.h"

namespace halflight {

/// For each patch and element a patch whose unknown it takes: itself, or if it has no rays, a patch beside it. The
/// search covers the 5 x 5 patches around, then the chart's rectangles of other axes; for triangles, the 8 before and
/// after in their mesh.
std::vector<PatchId> findSubstitutes(const Patches& patches, const std::vector<uint32_t>& rayCount,
                                     const BakeGeometry& geometry);

} // namespace halflight
