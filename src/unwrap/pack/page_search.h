#pragma once
// Searches for a density and for a page size, with as few packings as possible: a small page tells how well these
// charts fill one, and the height that a packing takes tells how far off it was.

#include "unwrap/pack/pages.h"

#include <optional>

namespace halflight::charts {

/// Share of a page's texels that charts with half of their padding will fill: measured on a page with a quarter of the
/// columns, or with half of them where charts are many.
double expectedShare(const std::vector<GroupLayout>& groups, const PageSettings& settings, const Progress& progress);

/// Density at which charts with half of their padding take that share of a page.
double densityOfShare(const std::vector<GroupLayout>& groups, const PageSettings& settings, double share);

/// The greatest density up to `most` at which everything fits one page. Mostly two packings. Nothing where none was
/// found, or when cancelled.
std::optional<Pages> fillPage(const std::vector<GroupLayout>& groups, const PageSettings& settings, double share,
                              double most, const Progress& progress);

/// The smallest page, up to settings.pageSize, that everything fits at a density. Mostly two packings. Nothing where
/// no page does, or when cancelled.
std::optional<Pages> smallestPage(const std::vector<GroupLayout>& groups, const PageSettings& settings, double share,
                                  double texelsPerMeter, const Progress& progress);

} // namespace halflight::charts
