#pragma once

#include "halflight/base/progress.h"
#include "unwrap/charts/chart.h"

namespace halflight::charts {

/// Joins neighbouring charts as long as the whole still flattens well. `chartOfTriangle` is kept up to date.
/// `texelMeters` is about the size of a texel to come: what is thinner than a texel may also bend around a crease.
void mergeCharts(const Surface& surface, std::vector<Chart>& charts, std::vector<uint32_t>& chartOfTriangle,
                 double texelMeters, const Progress& progress);

} // namespace halflight::charts
