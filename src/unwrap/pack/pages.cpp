#include "unwrap/pack/pages.h"

#include "halflight/unwrap/unwrap.h"

#include "unwrap/pack/attempt.h"
#include "unwrap/pack/estimate.h"
#include "unwrap/pack/page_search.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <optional>

namespace halflight::charts {
namespace {

std::string nameOf(const GroupLayout& group)
{
    return fmt::format("mesh {}", group.group.mesh);
}

/// Charts of a texel each that a page holds.
double mostCharts(const PageSettings& settings)
{
    const double inRow = std::floor(double(settings.pageSize + settings.padding) / double(1 + settings.padding));
    return inRow * inRow;
}

Error tooManyCharts(const GroupLayout& group, const PageSettings& settings)
{
    const double side = std::sqrt(2.0 * double(group.layout.charts.size())) * double(1 + settings.padding);
    return {ErrorCode::InvalidArgument,
            fmt::format("{} has {} charts, too many for one page of {} x {} texels with a padding of {}: it takes "
                        "pages of about {} texels, or a mesh in pieces",
                        nameOf(group), group.layout.charts.size(), settings.pageSize, settings.pageSize,
                        settings.padding, 64 * int(std::ceil(side / 64.0))),
            ""};
}

/// Packs at a density, on as many pages as it takes. What is too large for a page gets fewer texels.
Result<Pages> placeAtDensity(std::vector<GroupLayout>& groups, const PageSettings& settings, double density,
                             DensityFrom from, std::vector<std::string>& warnings, const Progress& progress)
{
    std::vector<std::size_t> tooLarge;
    const double page = double(settings.pageSize) * double(settings.pageSize);
    while (!progress.cancelled()) {
        progress("pack", 0.0);
        const bool mayFitOne = estimateTexels(groups, settings.padding).at(density) < kHopeless * page;
        Pages pages = packAllPages(groups, settings, density, mayFitOne, tooLarge, progress);
        if (progress.cancelled()) break;
        if (tooLarge.empty()) {
            if (settings.cutPage && pages.pageCount == 1) {
                std::optional<Pages> smaller = smallestPage(groups, settings, 0.95, density, progress);
                if (smaller) pages = std::move(*smaller);
            }
            pages.densityFrom = from;
            return pages;
        }
        for (const std::size_t g : tooLarge) {
            const double extent = largestExtent(groups[g]) * texelsPerUnit(groups[g], density);
            double shrink = extent > settings.pageSize - 1 ? 0.999 * (settings.pageSize - 1) / extent : 0.9;
            const TexelEstimate estimate = estimateObject(groups[g], settings.padding);
            const double texels = estimate.at(density);
            // A texel for each chart is left, and padding.
            if (texels < 1.02 * estimate.constant) return tooManyCharts(groups[g], settings);
            if (texels > kHopeless * page) shrink = std::min(shrink, std::sqrt(page / texels));
            if (groups[g].densityScale == 1.0) {
                warnings.push_back(
                    fmt::format("{} does not fit a page of {} texels at {:.4g} texels per metre: it gets fewer",
                                nameOf(groups[g]), settings.pageSize, density));
            }
            groups[g].densityScale *= shrink;
        }
    }
    return Pages{};
}

} // namespace

Result<Pages> placeOnPages(std::vector<GroupLayout>& groups, const PageSettings& settings,
                           std::vector<std::string>& warnings, const Progress& progress)
{
    if (groups.empty()) return Pages{};
    for (const GroupLayout& group : groups) {
        if (double(group.layout.charts.size()) > mostCharts(settings)) return tooManyCharts(group, settings);
    }
    const double page = double(settings.pageSize) * double(settings.pageSize);
    const TexelEstimate estimate = estimateTexels(groups, settings.padding);
    const double share = expectedShare(groups, settings, progress);
    double density = settings.texelsPerMeter;
    DensityFrom from = DensityFrom::Asked;
    const auto cut = [&](double texelsPerMeter) {
        std::optional<Pages> pages = smallestPage(groups, settings, share, texelsPerMeter, progress);
        if (pages) pages->densityFrom = from;
        return pages;
    };
    if (density <= 0.0) {
        const double most = settings.mostTexelsPerMeter > 0.0 ? settings.mostTexelsPerMeter : 1e30;
        if (settings.cutPage && most < densityOfShare(groups, settings, 1.02 * share)) {
            from = DensityFrom::Scene;
            if (std::optional<Pages> pages = cut(most)) return std::move(*pages);
        }
        from = DensityFrom::Page;
        if (std::optional<Pages> best = fillPage(groups, settings, share, most, progress)) {
            best->densityFrom = best->texelsPerMeter >= most ? DensityFrom::Scene : DensityFrom::Page;
            return std::move(*best);
        }
        if (progress.cancelled()) return Pages{};
        // So many charts that their padding alone fills a page.
        density = std::min(estimate.densityOf(0.9 * page), most);
        if (estimate.constant > 0.5 * page) density = estimate.densityOf(2.0 * estimate.constant);
        warnings.push_back(
            fmt::format("the objects do not fit one page of {0} x {0} texels at any density: using several pages "
                        "at {1:.4g} texels per metre",
                        settings.pageSize, density));
    }
    if (const Status status = checkPageCount(groups, density, settings); !status) return status.error();
    if (settings.cutPage && from == DensityFrom::Asked && estimate.at(density) < share * page) {
        if (std::optional<Pages> pages = cut(density)) return std::move(*pages);
    }
    return placeAtDensity(groups, settings, density, from, warnings, progress);
}

} // namespace halflight::charts
