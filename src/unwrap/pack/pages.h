#pragma once
// From layouts in metres to texels on pages.

#include "halflight/base/progress.h"
#include "halflight/base/result.h"
#include "halflight/unwrap/unwrap.h"
#include "unwrap/charts/layout.h"
#include "unwrap/objects/authored.h"
#include "unwrap/objects/objects.h"
#include "unwrap/pack/packer.h"

#include <cmath>
#include <memory>
#include <string>
#include <vector>

namespace halflight::charts {

/// A group with its layout: charts of our own, or the file's.
struct GroupLayout {
    LayoutGroup group;
    Layout layout;
    std::unique_ptr<AuthoredLayout> authored; ///< set when TEXCOORD_1 is kept
    std::string reason;                       ///< why it is not
    double densityScale = 1.0;                ///< below 1 where a chart or the whole object would not fit on a page
    std::size_t triangleCount = 0;

    /// Its charts go to the page one by one; otherwise each object gets a copy of the whole layout.
    [[nodiscard]] bool loose() const { return !authored && group.objects.size() == 1; }
};

/// One group's texels at some density.
struct GroupRaster {
    std::vector<Footprint> charts;  ///< of our own charts
    std::vector<dvec2> chartOrigin; ///< where a chart's (0, 0) lies in its footprint
    double texelsPerUnit = 1.0;     ///< texels per metre of the layout, or per uv unit of an authored one
    ivec2 authoredCorner{0};        ///< texel of the authored layout at which its footprint begins
    Block block;                    ///< places of the charts in the group's own rectangle, unless loose
    Footprint whole;                ///< all of that rectangle
};

/// Everything placed.
struct Pages {
    double texelsPerMeter = 0.0;
    DensityFrom densityFrom = DensityFrom::Page;
    int pageSize = 0;
    int pageCount = 0;
    std::vector<GroupRaster> rasters;               ///< by group
    std::vector<std::vector<Placement>> placements; ///< by group: of each chart when loose, else of each object
    std::size_t coveredTexels = 0;
    std::size_t reservedTexels = 0; ///< and the padding around them
};

struct PageSettings {
    int pageSize = 1024;
    int padding = 2;
    double texelsPerMeter = 0.0;     ///< 0 = the most that fits one page, but not more than the next
    double mostTexelsPerMeter = 0.0; ///< 0 = no limit
    bool cutPage = false;            ///< UnwrapSettings::cutPage
};

/// A page that is cut has so many texels on a side at least.
inline constexpr int kLeastCutPage = 16;
/// The next multiple of the 4 texels that pages are cut to: blocks of compressed textures.
inline int roundedUpToBlocks(double texels)
{
    return 4 * int(std::ceil(texels / 4.0));
}

/// Places all groups. Cancelled: pageCount is 0 while there are groups. Errors: InvalidArgument, when they would need
/// more than kMaxPages pages.
Result<Pages> placeOnPages(std::vector<GroupLayout>& groups, const PageSettings& settings,
                           std::vector<std::string>& warnings, const Progress& progress);

/// Texels that an authored layout touches at so many texels per uv unit, within the rectangle from `corner` on.
Footprint rasterizeLayout(const AuthoredLayout& layout, double texelsPerUnit, ivec2 corner, ivec2 size);

} // namespace halflight::charts
