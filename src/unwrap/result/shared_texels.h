#pragma once
// Proof that a finished layout keeps objects apart.

#include "halflight/base/progress.h"
#include "halflight/base/result.h"
#include "halflight/unwrap/unwrap.h"
#include "unwrap/pack/pages.h"

#include <vector>

namespace halflight::charts {

/// Rasterizes every triangle at its place on its page and fails where one texel is touched by two objects, or by two
/// charts of a layout that the unwrapper made. Works on the coordinates and bindings of the result alone. Errors:
/// Unsupported, with the objects' names; Cancelled.
Status checkSharedTexels(const UnwrappedScene& unwrapped, const std::vector<GroupLayout>& groups,
                         const Progress& progress);

} // namespace halflight::charts
