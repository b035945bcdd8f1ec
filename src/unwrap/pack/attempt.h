#pragma once
// One packing: all groups at one density.

#include "unwrap/pack/pages.h"

#include <optional>

namespace halflight::charts {

/// An object whose estimate is so many times a page's texels is not worth a try: the estimate is good to some percent.
inline constexpr double kHopeless = 1.3;

GroupRaster rasterizeGroup(const GroupLayout& group, double texelsPerMeter);

/// Everything on one page whose height is left open.
struct OpenPage {
    Pages pages;
    int height = 0; ///< rows from the top that are used
};
/// Packs on a page of settings.pageSize columns. Nothing when that takes more than `mostHeight` rows, when a group is
/// too large for a square page, or when cancelled.
std::optional<OpenPage> packOpenPage(const std::vector<GroupLayout>& groups, const PageSettings& settings,
                                     double texelsPerMeter, int mostHeight, const Progress& progress);

/// Packs on as many square pages as it takes. Groups that fit no page are reported in `tooLarge`: there are no pages
/// then. `mayFitOne`: one page is tried first.
Pages packAllPages(const std::vector<GroupLayout>& groups, const PageSettings& settings, double texelsPerMeter,
                   bool mayFitOne, std::vector<std::size_t>& tooLarge, const Progress& progress);

} // namespace halflight::charts
