#include "unwrap/layout.h"

#include "halflight/base/parallel.h"
#include "unwrap/cluster.h"
#include "unwrap/merge.h"

#include <cmath>

namespace halflight::charts {
namespace {

/// Flattens a connected set of triangles into as many charts as it takes: where it folds or overlaps it is split, and
/// a single triangle always lies flat.
void flattenOrSplit(const Surface& surface, std::vector<uint32_t> triangles, std::vector<Chart>& charts,
                    const Progress& progress)
{
    std::vector<std::vector<uint32_t>> waiting;
    waiting.push_back(std::move(triangles));
    while (!waiting.empty() && !progress.cancelled()) {
        std::vector<uint32_t> current = std::move(waiting.back());
        waiting.pop_back();
        Flattening flattening = flatten(surface, current);
        if (flattening.valid) {
            charts.push_back(std::move(flattening.chart));
            continue;
        }
        for (const std::vector<uint32_t>& half : splitTriangles(surface, current, flattening.seedA, flattening.seedB)) {
            for (std::vector<uint32_t>& piece : connectedPieces(surface, half)) waiting.push_back(std::move(piece));
        }
    }
}

} // namespace

double Layout::stretch() const
{
    double sum = 0.0;
    for (const Chart& chart : charts) sum += chart.area * chart.stretch * chart.stretch;
    return area > 0.0 ? std::sqrt(sum / area) : 1.0;
}

Layout makeLayout(const Surface& surface, double texelMeters, const Progress& progress)
{
    const Regions regions = clusterTriangles(surface);
    std::vector<std::vector<uint32_t>> members(regions.count);
    for (uint32_t t = 0; t < surface.triangleCount(); ++t) {
        if (regions.ofTriangle[t] != kNone) members[regions.ofTriangle[t]].push_back(t);
    }
    std::vector<std::vector<Chart>> charts(regions.count);
    parallelFor(regions.count, 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t r = begin; r < end; ++r) flattenOrSplit(surface, std::move(members[r]), charts[r], progress);
    });

    Layout layout;
    layout.chartOfTriangle.assign(surface.triangleCount(), kNone);
    for (std::vector<Chart>& some : charts) {
        for (Chart& chart : some) {
            for (const uint32_t t : chart.triangles) layout.chartOfTriangle[t] = uint32_t(layout.charts.size());
            layout.area += chart.area;
            layout.charts.push_back(std::move(chart));
        }
    }
    mergeCharts(surface, layout.charts, layout.chartOfTriangle, texelMeters, progress);
    return layout;
}

} // namespace halflight::charts
