#pragma once

#include "halflight/base/progress.h"
#include "unwrap/charts/chart.h"

namespace halflight::charts {

/// A surface cut into flattened charts.
struct Layout {
    std::vector<Chart> charts;
    std::vector<uint32_t> chartOfTriangle; ///< kNone for degenerate triangles
    double area = 0.0;                     ///< of all charts, square metres

    /// Area-weighted L2 stretch over all charts, 1 = isometric.
    [[nodiscard]] double stretch() const;
};

/// `texelMeters` is about the size of a texel to come: charts smaller than a few of them are merged more freely.
Layout makeLayout(const Surface& surface, double texelMeters, const Progress& progress);

} // namespace halflight::charts
