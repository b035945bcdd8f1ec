#include "unwrap/pack/page_search.h"

#include "halflight/base/parallel.h"
#include "unwrap/pack/attempt.h"
#include "unwrap/pack/estimate.h"

#include <algorithm>
#include <cmath>

namespace halflight::charts {
namespace {

constexpr int kTrials = 9;           ///< packings at full size, at most: where charts are few, chance decides what fits
constexpr double kLeastGain = 0.008; ///< of the page's texels: for less, nothing is packed again
/// With fewer charts than this one more in a row decides what fits, and packings take little time: the search goes on.
constexpr std::size_t kFewCharts = 1000;
constexpr double kMargin = 0.002; ///< of the texels: how well the height of one packing tells that of the next

double texelsOf(const PageSettings& settings)
{
    return double(settings.pageSize) * double(settings.pageSize);
}

/// Rows of an open page: enough to learn how far off a density is.
int rowsOfOpenPage(int pageSize)
{
    return pageSize + pageSize / 4 + 16;
}

/// Texels of all charts at a density with half of their padding, from drawing them. Gaps between the charts of one
/// object count as what a packing loses.
double reservedTexels(const std::vector<GroupLayout>& groups, int padding, double texelsPerMeter)
{
    std::vector<double> texels(groups.size(), 0.0);
    parallelFor(groups.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t g = begin; g < end; ++g) {
            const GroupRaster raster = rasterizeGroup(groups[g], texelsPerMeter);
            double own = 0.0;
            for (const Footprint& chart : raster.charts) own += double(chart.dilated(padding / 2).count());
            if (groups[g].authored) own = double(raster.whole.dilated(padding / 2).count());
            texels[g] = own * double(groups[g].group.objects.size());
        }
    });
    double sum = 0.0;
    for (const double own : texels) sum += own;
    return sum;
}

/// Density above which something that has to stay in one piece is larger than a page.
double densityOfLargest(const std::vector<GroupLayout>& groups, const PageSettings& settings)
{
    double density = 1e9;
    for (const GroupLayout& group : groups) {
        const double extent = largestExtent(group) * texelsPerUnit(group, 1.0);
        if (extent > 0.0) density = std::min(density, 0.9999 * (settings.pageSize - 1) / extent);
    }
    return density;
}

std::size_t chartsOf(const std::vector<GroupLayout>& groups)
{
    std::size_t count = 0;
    for (const GroupLayout& group : groups) count += group.layout.charts.size();
    return count;
}

/// What the trials of fillPage() have shown.
struct DensityBracket {
    bool goesOn = false; ///< until little is left between what fits and what fails
    double fits = 0.0;
    double fails = 0.0; ///< 0: nothing failed yet
    int failures = 0;

    /// After a packing that took `height` rows, 0 where it took too many.
    [[nodiscard]] double next(const TexelEstimate& estimate, int pageSize, double density, int height) const
    {
        double value = density * (failures < 3 ? 0.94 : failures < 5 ? 0.8 : 0.33);
        if (height > 0) {
            const double margin = kMargin * (1 + failures);
            value = estimate.densityOf(estimate.at(density) * (1.0 - margin) * double(pageSize) / double(height));
        }
        // Beyond what is known, half way to it.
        if (fits > 0.0 && fails > 0.0 && (goesOn || value <= fits || value >= fails)) return std::sqrt(fits * fails);
        if (fits > 0.0 && goesOn) return std::max(value, 1.03 * fits);
        return value;
    }
};

} // namespace

double densityOfShare(const std::vector<GroupLayout>& groups, const PageSettings& settings, double share)
{
    const TexelEstimate estimate = estimateTexels(groups, settings.padding);
    const double wanted = share * texelsOf(settings);
    double density = estimate.densityOf(wanted);
    if (estimate.constant > 0.9 * wanted) return density; // drawing them would be no better
    density = std::min(density, densityOfLargest(groups, settings));
    return estimate.densityOf(wanted * estimate.at(density) / reservedTexels(groups, settings.padding, density));
}

double expectedShare(const std::vector<GroupLayout>& groups, const PageSettings& settings, const Progress& progress)
{
    constexpr double kUsual = 0.95;
    constexpr double kMostPadding = 0.5; // of the small page: with more, charts fill it in another way
    const TexelEstimate estimate = estimateTexels(groups, settings.padding);
    PageSettings small = settings;
    const auto isCrowded = [&] { return estimate.constant > kMostPadding * texelsOf(small); };
    small.pageSize = settings.pageSize / 4;
    if (isCrowded()) small.pageSize = settings.pageSize / 2;
    if (small.pageSize < 128 || isCrowded()) return kUsual;
    const double density = std::min(estimate.densityOf(0.9 * texelsOf(small)), densityOfLargest(groups, small));
    const std::optional<OpenPage> open = packOpenPage(groups, small, density, rowsOfOpenPage(small.pageSize), progress);
    if (!open || open->height < small.pageSize / 2) return kUsual;
    const double texels = reservedTexels(groups, settings.padding, density);
    return std::min(texels / (double(small.pageSize) * double(open->height)), 1.0);
}

std::optional<Pages> fillPage(const std::vector<GroupLayout>& groups, const PageSettings& settings, double share,
                              double most, const Progress& progress)
{
    const TexelEstimate estimate = estimateTexels(groups, settings.padding);
    const double limit = std::min(most, densityOfLargest(groups, settings));
    double density = std::min(densityOfShare(groups, settings, share), limit);
    DensityBracket bracket{chartsOf(groups) < kFewCharts};
    std::optional<Pages> best;
    for (int trial = 0; trial < kTrials && !progress.cancelled(); ++trial) {
        progress("pack", std::min(0.1 + 0.4 * trial, 0.9));
        std::optional<OpenPage> open =
            packOpenPage(groups, settings, density, rowsOfOpenPage(settings.pageSize), progress);
        const int height = open ? open->height : 0;
        if (open && height <= settings.pageSize) {
            best = std::move(open->pages);
            bracket.fits = density;
            if (density >= limit) break;
        } else {
            bracket.fails = density;
            ++bracket.failures;
        }
        if (best && bracket.fails > 0.0 && bracket.fails / bracket.fits < 1.008) break;
        const double next = std::min(bracket.next(estimate, settings.pageSize, density, height), limit);
        if (best && !bracket.goesOn) {
            const double growth = next / bracket.fits;
            if (double(best->coveredTexels) * (growth * growth - 1.0) < kLeastGain * texelsOf(settings)) break;
        }
        density = next;
        if (density <= bracket.fits) break;
    }
    return best;
}

std::optional<Pages> smallestPage(const std::vector<GroupLayout>& groups, const PageSettings& settings, double share,
                                  double texelsPerMeter, const Progress& progress)
{
    const double texels = reservedTexels(groups, settings.padding, texelsPerMeter);
    double extent = 0.0;
    for (const GroupLayout& group : groups)
        extent = std::max(extent, largestExtent(group) * texelsPerUnit(group, texelsPerMeter));
    const int least = std::max(kLeastCutPage, roundedUpToBlocks(extent + 1.0));
    int size = std::max(roundedUpToBlocks(std::sqrt(texels / share)), least);
    std::optional<Pages> best;
    for (int trial = 0; trial < kTrials && !progress.cancelled(); ++trial) {
        size = std::min(size, settings.pageSize);
        PageSettings page = settings;
        page.pageSize = size;
        std::optional<OpenPage> open = packOpenPage(groups, page, texelsPerMeter, rowsOfOpenPage(size), progress);
        const int fair = open ? std::max(roundedUpToBlocks(std::sqrt(double(size) * double(open->height))), least) : 0;
        if (open && open->height <= size) {
            const bool isSecond = best.has_value();
            best = std::move(open->pages);
            if (isSecond || fair > size - std::max(4, size / 128)) break;
            size = fair;
        } else {
            if (best || size == settings.pageSize) break;
            size = std::max(open ? fair : roundedUpToBlocks(1.1 * size), size + 4);
        }
    }
    return best;
}

} // namespace halflight::charts
