#include "unwrap/pack/pages.h"

#include "halflight/unwrap/unwrap.h"

#include "halflight/base/parallel.h"
#include "unwrap/pack/page_search.h"
#include "unwrap/pack/trials.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <optional>

namespace halflight::charts {
namespace {

/// An object whose estimate is so many times a page's texels is not worth a try: the estimate is good to some percent.
constexpr double kHopeless = 1.3;

/// The chart in the middle of the least rectangle of whole texels that holds it.
void rasterizeChart(const Chart& chart, double texelsPerMeter, Footprint& footprint, dvec2& origin)
{
    const dvec2 size = chart.size * texelsPerMeter;
    const ivec2 texels = glm::max(ivec2(glm::ceil(size + 2.0 * kRasterMargin + 1e-6)), ivec2(1));
    origin = 0.5 * (dvec2(texels) - size);
    footprint = Footprint(texels.x, texels.y);
    for (std::size_t t = 0; t < chart.triangles.size(); ++t) {
        dvec2 corners[3];
        for (std::size_t k = 0; k < 3; ++k) corners[k] = origin + chart.uv[chart.corners[3 * t + k]] * texelsPerMeter;
        forTouchedTexels(corners, kRasterMargin, [&](int y, int first, int last) { footprint.setRun(y, first, last); });
    }
}

void rasterizeAuthored(const AuthoredLayout& authored, GroupRaster& raster)
{
    const double scale = raster.texelsPerUnit;
    raster.authoredCorner = ivec2(glm::floor(authored.least * scale - 2.0 * kRasterMargin));
    const ivec2 end = ivec2(glm::floor(authored.most * scale + 2.0 * kRasterMargin)) + 1;
    raster.whole = rasterizeLayout(authored, scale, raster.authoredCorner, end - raster.authoredCorner);
}

double texelsPerUnit(const GroupLayout& group, double texelsPerMeter)
{
    const double density = texelsPerMeter * group.densityScale;
    return group.authored ? density * std::sqrt(group.authored->worldArea / group.authored->uvArea) : density;
}

/// Size of the largest thing that has to stay in one piece, in layout units.
double largestExtent(const GroupLayout& group)
{
    if (group.authored) {
        const dvec2 size = group.authored->most - group.authored->least;
        return std::max(size.x, size.y);
    }
    double extent = 0.0;
    for (const Chart& chart : group.layout.charts) extent = std::max({extent, chart.size.x, chart.size.y});
    return extent;
}

/// Texels that one object of the group takes at a density, padding included: a chart of area A and perimeter P, grown
/// by half the padding and half a texel all round, as if its outline were smooth.
double estimateObject(const GroupLayout& group, double texelsPerMeter, int padding)
{
    const double grow = 0.5 * (padding + 1);
    if (group.authored) {
        // Authored charts keep their gaps: the rectangle that holds them counts.
        const dvec2 size = (group.authored->most - group.authored->least) * texelsPerUnit(group, texelsPerMeter);
        return (size.x + 2.0 * grow) * (size.y + 2.0 * grow);
    }
    const double density = texelsPerMeter * group.densityScale;
    double texels = 0.0;
    for (const Chart& chart : group.layout.charts) {
        texels +=
            chart.area * density * density + 0.55 * chart.perimeter * density * grow * 2.0 + 4.0 * grow * grow * 0.8;
    }
    return group.layout.charts.empty() ? 4.0 * grow * grow : texels;
}

GroupRaster rasterizeGroup(const GroupLayout& group, double texelsPerMeter)
{
    GroupRaster raster;
    raster.texelsPerUnit = texelsPerUnit(group, texelsPerMeter);
    if (group.authored) {
        rasterizeAuthored(*group.authored, raster);
        return raster;
    }
    const std::size_t count = group.layout.charts.size();
    if (count == 0) { // nothing but degenerate triangles: they all get one texel
        raster.charts.assign(1, Footprint(1, 1));
        raster.charts[0].set(0, 0);
        raster.chartOrigin.assign(1, dvec2(0.5));
        return raster;
    }
    raster.charts.resize(count);
    raster.chartOrigin.resize(count);
    parallelFor(count, 32, [&](std::size_t begin, std::size_t end) {
        for (std::size_t c = begin; c < end; ++c) {
            rasterizeChart(group.layout.charts[c], raster.texelsPerUnit, raster.charts[c], raster.chartOrigin[c]);
        }
    });
    return raster;
}

/// The group's charts in a rectangle of their own.
bool makeBlock(GroupRaster& raster, int pageSize, int padding, const Progress& progress)
{
    std::vector<PackItem> items;
    for (const Footprint& chart : raster.charts) items.push_back({&chart, 0, true});
    std::optional<Block> block = packBlock(items, ivec2(pageSize), padding, progress);
    if (!block) return false;
    raster.block = std::move(*block);
    raster.whole = Footprint(raster.block.size.x, raster.block.size.y);
    for (std::size_t c = 0; c < raster.charts.size(); ++c) {
        const Placement& placement = raster.block.placements[c];
        raster.charts[c].oriented(placement.orientation).forRuns([&](int y, int x, int length) {
            raster.whole.setRun(placement.at.y + y, placement.at.x + x, placement.at.x + x + length - 1);
        });
    }
    return true;
}

/// All groups at one density, packed. With `onePage`, no pages at all when one does not suffice. Groups that fit no
/// page are reported in `tooLarge`.
Pages attempt(const std::vector<GroupLayout>& groups, const PageSettings& settings, double texelsPerMeter, bool onePage,
              std::vector<std::size_t>& tooLarge, const Progress& progress)
{
    Pages pages;
    pages.texelsPerMeter = texelsPerMeter;
    pages.pageSize = settings.pageSize;
    pages.rasters.resize(groups.size());
    tooLarge.clear();
    const double page = double(settings.pageSize) * double(settings.pageSize);
    for (std::size_t g = 0; g < groups.size(); ++g) {
        if (largestExtent(groups[g]) * texelsPerUnit(groups[g], texelsPerMeter) > settings.pageSize - 1 ||
            estimateObject(groups[g], texelsPerMeter, settings.padding) > kHopeless * page)
            tooLarge.push_back(g);
    }
    if (!tooLarge.empty()) return pages;
    std::vector<char> failed(groups.size(), 0);
    parallelFor(groups.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t g = begin; g < end; ++g) {
            if (progress.cancelled()) continue;
            pages.rasters[g] = rasterizeGroup(groups[g], texelsPerMeter);
            if (!groups[g].authored && !groups[g].loose()) {
                failed[g] = !makeBlock(pages.rasters[g], settings.pageSize, settings.padding, progress);
            }
        }
    });
    if (progress.cancelled()) return pages;
    std::vector<PackItem> items;
    std::vector<std::pair<std::size_t, std::size_t>> owner; // group, place in its list of placements
    uint32_t packGroup = 0;
    pages.placements.resize(groups.size());
    for (std::size_t g = 0; g < groups.size(); ++g) {
        if (failed[g]) {
            tooLarge.push_back(g);
            continue;
        }
        const GroupRaster& raster = pages.rasters[g];
        const bool loose = groups[g].loose();
        const std::size_t count = loose ? raster.charts.size() : groups[g].group.objects.size();
        pages.placements[g].resize(count);
        for (std::size_t i = 0; i < count; ++i) {
            items.push_back({loose ? &raster.charts[i] : &raster.whole, packGroup, loose});
            owner.emplace_back(g, i);
            if (!loose) ++packGroup;
        }
        if (loose) ++packGroup;
    }
    if (!tooLarge.empty()) return pages;
    std::vector<Placement> placements = packOnePage(items, ivec2(settings.pageSize), settings.padding, progress);
    if (placements.empty()) {
        if (onePage || progress.cancelled()) return pages;
        placements = packPages(items, ivec2(settings.pageSize), settings.padding, progress);
        if (progress.cancelled()) return pages;
    }
    for (std::size_t i = 0; i < items.size(); ++i) {
        const auto [g, place] = owner[i];
        pages.placements[g][place] = placements[i];
        pages.pageCount = std::max(pages.pageCount, placements[i].page + 1);
        if (placements[i].page < 0 && (tooLarge.empty() || tooLarge.back() != g)) tooLarge.push_back(g);
        pages.coveredTexels += items[i].footprint->count();
        pages.reservedTexels += items[i].footprint->dilated(settings.padding / 2).count();
    }
    return pages;
}

/// Everything on one page at a density, or nothing; nothing when cancelled.
std::optional<Pages> attemptOnePage(const std::vector<GroupLayout>& groups, const PageSettings& settings,
                                    double texelsPerMeter, const Progress& progress)
{
    if (progress.cancelled()) return std::nullopt;
    std::vector<std::size_t> tooLarge;
    Pages pages = attempt(groups, settings, texelsPerMeter, true, tooLarge, progress);
    return pages.pageCount == 1 && tooLarge.empty() ? std::optional(std::move(pages)) : std::nullopt;
}

double estimateTexels(const std::vector<GroupLayout>& groups, double texelsPerMeter, int padding)
{
    double sum = 0.0;
    for (const GroupLayout& group : groups)
        sum += estimateObject(group, texelsPerMeter, padding) * double(group.group.objects.size());
    return sum;
}

/// Pages for everything at a density, objects larger than a page included.
double estimatePages(const std::vector<GroupLayout>& groups, double texelsPerMeter, const PageSettings& settings)
{
    return estimateTexels(groups, texelsPerMeter, settings.padding) /
           (double(settings.pageSize) * double(settings.pageSize));
}

/// Refuses what would need far too many pages, before any work on it.
Status checkPageCount(const std::vector<GroupLayout>& groups, double texelsPerMeter, const PageSettings& settings)
{
    const double pages = estimatePages(groups, texelsPerMeter, settings);
    if (pages <= kMaxPages) return {};
    const std::string needed =
        fmt::format("{:.4g} texels per metre need about {:.0f} pages of {} x {} texels and {} are the most",
                    texelsPerMeter, std::ceil(pages), settings.pageSize, settings.pageSize, kMaxPages);
    double fits = 0.0, fails = texelsPerMeter;
    for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (fits + fails);
        (estimatePages(groups, middle, settings) <= 0.9 * kMaxPages ? fits : fails) = middle;
    }
    if (fits <= 1e-6 * texelsPerMeter) {
        return Error{ErrorCode::InvalidArgument,
                     needed + ": the objects are too many for any density at this page size", ""};
    }
    const double unit = std::pow(10.0, std::floor(std::log10(fits)) - 1.0); // two digits, rounded down
    return Error{ErrorCode::InvalidArgument,
                 fmt::format("{}: {:.4g} texels per metre would fit", needed, std::floor(fits / unit) * unit), ""};
}

/// The smallest page that everything fits at the density of `whole`, which is one page. Each trial is a whole packing.
Pages cutPage(const std::vector<GroupLayout>& groups, const PageSettings& settings, Pages whole,
              const Progress& progress)
{
    const double estimate = std::sqrt(estimateTexels(groups, whole.texelsPerMeter, settings.padding) / 0.95);
    PageSearch search(settings.pageSize, roundedUpToBlocks(estimate));
    const auto evaluate = [&](int size) {
        PageSettings trial = settings;
        trial.pageSize = size;
        return attemptOnePage(groups, trial, whole.texelsPerMeter, progress);
    };
    const auto report = [](const PageSearch&) {};
    std::optional<Pages> best = searchByTrials<Pages>(search, trialDepth(threadCount()), evaluate, report);
    if (!best || progress.cancelled()) return whole;
    best->densityFrom = whole.densityFrom;
    return std::move(*best);
}

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

} // namespace

Footprint rasterizeLayout(const AuthoredLayout& layout, double texelsPerUnit, ivec2 corner, ivec2 size)
{
    Footprint footprint(size.x, size.y);
    for (const FlatTriangle& triangle : layout.triangles) {
        dvec2 corners[3];
        for (int k = 0; k < 3; ++k) corners[k] = triangle.corners[k] * texelsPerUnit - dvec2(corner);
        forTouchedTexels(corners, kRasterMargin, [&](int y, int first, int last) { footprint.setRun(y, first, last); });
    }
    return footprint;
}

double estimateDensity(const std::vector<GroupLayout>& groups, const PageSettings& settings, double share)
{
    const double wanted = share * double(settings.pageSize) * double(settings.pageSize);
    double low = 1e-9, high = 1e9;
    for (int i = 0; i < 100; ++i) {
        const double middle = std::sqrt(low * high);
        (estimateTexels(groups, middle, settings.padding) < wanted ? low : high) = middle;
    }
    return low;
}

Result<Pages> placeOnPages(std::vector<GroupLayout>& groups, const PageSettings& settings,
                           std::vector<std::string>& warnings, const Progress& progress)
{
    if (groups.empty()) return Pages{};
    for (const GroupLayout& group : groups) {
        if (double(group.layout.charts.size()) > mostCharts(settings)) return tooManyCharts(group, settings);
    }
    std::vector<std::size_t> tooLarge;
    double density = settings.texelsPerMeter;
    const auto finished = [&](Pages pages, DensityFrom from) {
        pages.densityFrom = from;
        if (!settings.cutPage || pages.pageCount != 1 || progress.cancelled()) return pages;
        return cutPage(groups, settings, std::move(pages), progress);
    };
    DensityFrom from = DensityFrom::Asked;
    if (density <= 0.0) {
        const double most = settings.mostTexelsPerMeter > 0.0 ? settings.mostTexelsPerMeter : 1e30;
        DensitySearch search{most, std::min(estimateDensity(groups, settings, 0.93), most)};
        const auto evaluate = [&](double trial) { return attemptOnePage(groups, settings, trial, progress); };
        const auto report = [&](const DensitySearch& s) { progress("pack", double(s.trial) / DensitySearch::kTrials); };
        std::optional<Pages> best = searchByTrials<Pages>(search, trialDepth(threadCount()), evaluate, report);
        if (progress.cancelled()) return Pages{};
        if (best) return finished(std::move(*best), search.fits >= most ? DensityFrom::Scene : DensityFrom::Page);
        from = DensityFrom::Page;
        // So many charts that their padding alone fills a page.
        density = std::min(estimateDensity(groups, settings, 0.9), most);
        const double least = estimateTexels(groups, 0.0, settings.padding);
        const double page = double(settings.pageSize) * double(settings.pageSize);
        if (least > 0.5 * page) density = estimateDensity(groups, settings, 2.0 * least / page);
        warnings.push_back(
            fmt::format("the objects do not fit one page of {0} x {0} texels at any density: using several pages "
                        "at {1:.4g} texels per metre",
                        settings.pageSize, density));
    }
    if (const Status status = checkPageCount(groups, density, settings); !status) return status.error();
    const double page = double(settings.pageSize) * double(settings.pageSize);
    while (!progress.cancelled()) {
        progress("pack", 0.0);
        Pages pages = attempt(groups, settings, density, false, tooLarge, progress);
        if (progress.cancelled()) break;
        if (tooLarge.empty()) return finished(std::move(pages), from);
        for (const std::size_t g : tooLarge) {
            const double extent = largestExtent(groups[g]) * texelsPerUnit(groups[g], density);
            double shrink = extent > settings.pageSize - 1 ? 0.999 * (settings.pageSize - 1) / extent : 0.9;
            const double texels = estimateObject(groups[g], density, settings.padding);
            // A texel for each chart is left, and padding.
            if (texels < 1.02 * estimateObject(groups[g], 0.0, settings.padding))
                return tooManyCharts(groups[g], settings);
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

} // namespace halflight::charts
