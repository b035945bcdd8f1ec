#include "unwrap/pack/attempt.h"

#include "halflight/base/parallel.h"
#include "unwrap/pack/estimate.h"

#include <algorithm>
#include <cmath>

namespace halflight::charts {
namespace {

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

std::vector<std::size_t> groupsTooLarge(const std::vector<GroupLayout>& groups, const PageSettings& settings,
                                        double texelsPerMeter)
{
    std::vector<std::size_t> tooLarge;
    const double page = double(settings.pageSize) * double(settings.pageSize);
    for (std::size_t g = 0; g < groups.size(); ++g) {
        if (largestExtent(groups[g]) * texelsPerUnit(groups[g], texelsPerMeter) > settings.pageSize - 1 ||
            estimateObject(groups[g], settings.padding).at(texelsPerMeter) > kHopeless * page)
            tooLarge.push_back(g);
    }
    return tooLarge;
}

/// What lies on pages on its own: a chart of a loose group, or an object with all its charts.
struct PlacedItems {
    std::vector<PackItem> items;
    std::vector<std::pair<std::size_t, std::size_t>> owners; ///< group, place in its list of placements
};

PlacedItems itemsOf(const std::vector<GroupLayout>& groups, Pages& pages)
{
    PlacedItems placed;
    uint32_t packGroup = 0;
    pages.placements.resize(groups.size());
    for (std::size_t g = 0; g < groups.size(); ++g) {
        const GroupRaster& raster = pages.rasters[g];
        const bool loose = groups[g].loose();
        const std::size_t count = loose ? raster.charts.size() : groups[g].group.objects.size();
        pages.placements[g].resize(count);
        for (std::size_t i = 0; i < count; ++i) {
            placed.items.push_back({loose ? &raster.charts[i] : &raster.whole, packGroup, loose});
            placed.owners.emplace_back(g, i);
            if (!loose) ++packGroup;
        }
        if (loose) ++packGroup;
    }
    return placed;
}

/// Draws all groups; returns those whose charts fit no rectangle of a page.
std::vector<std::size_t> drawGroups(const std::vector<GroupLayout>& groups, const PageSettings& settings, Pages& pages,
                                    const Progress& progress)
{
    pages.pageSize = settings.pageSize;
    pages.rasters.resize(groups.size());
    std::vector<char> failed(groups.size(), 0);
    parallelFor(groups.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t g = begin; g < end; ++g) {
            if (progress.cancelled()) continue;
            pages.rasters[g] = rasterizeGroup(groups[g], pages.texelsPerMeter);
            if (!groups[g].authored && !groups[g].loose())
                failed[g] = !makeBlock(pages.rasters[g], settings.pageSize, settings.padding, progress);
        }
    });
    std::vector<std::size_t> tooLarge;
    for (std::size_t g = 0; g < groups.size(); ++g)
        if (failed[g]) tooLarge.push_back(g);
    return tooLarge;
}

/// Takes over where items lie; returns the groups of those that lie nowhere.
std::vector<std::size_t> takePlacements(const PlacedItems& placed, const std::vector<Placement>& placements,
                                        int padding, Pages& pages)
{
    std::vector<std::size_t> tooLarge;
    for (std::size_t i = 0; i < placed.items.size(); ++i) {
        const auto [g, place] = placed.owners[i];
        pages.placements[g][place] = placements[i];
        pages.pageCount = std::max(pages.pageCount, placements[i].page + 1);
        if (placements[i].page < 0 && (tooLarge.empty() || tooLarge.back() != g)) tooLarge.push_back(g);
        pages.coveredTexels += placed.items[i].footprint->count();
        pages.reservedTexels += placed.items[i].footprint->dilated(padding / 2).count();
    }
    return tooLarge;
}

} // namespace

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

std::optional<OpenPage> packOpenPage(const std::vector<GroupLayout>& groups, const PageSettings& settings,
                                     double texelsPerMeter, int mostHeight, const Progress& progress)
{
    if (progress.cancelled() || !groupsTooLarge(groups, settings, texelsPerMeter).empty()) return std::nullopt;
    OpenPage open;
    Pages& pages = open.pages;
    pages.texelsPerMeter = texelsPerMeter;
    if (!drawGroups(groups, settings, pages, progress).empty() || progress.cancelled()) return std::nullopt;
    const PlacedItems placed = itemsOf(groups, pages);
    const std::optional<Block> block =
        packOnePage(placed.items, ivec2(settings.pageSize, mostHeight), settings.padding, progress);
    if (!block) return std::nullopt;
    open.height = block->size.y;
    takePlacements(placed, block->placements, settings.padding, pages);
    return open;
}

Pages packAllPages(const std::vector<GroupLayout>& groups, const PageSettings& settings, double texelsPerMeter,
                   bool mayFitOne, std::vector<std::size_t>& tooLarge, const Progress& progress)
{
    Pages pages;
    pages.texelsPerMeter = texelsPerMeter;
    pages.pageSize = settings.pageSize;
    tooLarge = groupsTooLarge(groups, settings, texelsPerMeter);
    if (!tooLarge.empty()) return pages;
    tooLarge = drawGroups(groups, settings, pages, progress);
    if (!tooLarge.empty() || progress.cancelled()) return pages;
    const PlacedItems placed = itemsOf(groups, pages);
    const ivec2 size(settings.pageSize);
    std::optional<Block> one;
    if (mayFitOne) one = packOnePage(placed.items, size, settings.padding, progress);
    if (progress.cancelled()) return pages;
    const std::vector<Placement> placements =
        one ? std::move(one->placements) : packPages(placed.items, size, settings.padding, progress);
    if (progress.cancelled()) return pages;
    tooLarge = takePlacements(placed, placements, settings.padding, pages);
    return pages;
}

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

} // namespace halflight::charts
