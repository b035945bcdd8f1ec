#pragma once
// How many texels groups take at a density, before any is drawn.

#include "unwrap/pack/pages.h"

namespace halflight::charts {

/// Texels per metre of a group's layout, or per uv unit of an authored one.
double texelsPerUnit(const GroupLayout& group, double texelsPerMeter);

/// Size of the largest thing that has to stay in one piece, in layout units.
double largestExtent(const GroupLayout& group);

/// Texels with padding, by density. A chart of area A and perimeter P grows by half the padding and half a texel all
/// round, as if its outline were smooth. Good to some per cent.
struct TexelEstimate {
    double square = 0.0, linear = 0.0, constant = 0.0; ///< of texels per metre

    [[nodiscard]] double at(double texelsPerMeter) const
    {
        return (square * texelsPerMeter + linear) * texelsPerMeter + constant;
    }
    /// Density at which it is `texels`; nearly 0 where there is none.
    [[nodiscard]] double densityOf(double texels) const;
};
TexelEstimate estimateObject(const GroupLayout& group, int padding);
TexelEstimate estimateTexels(const std::vector<GroupLayout>& groups, int padding); ///< all objects

/// Refuses what would need far too many pages, before any work on it.
Status checkPageCount(const std::vector<GroupLayout>& groups, double texelsPerMeter, const PageSettings& settings);

} // namespace halflight::charts
