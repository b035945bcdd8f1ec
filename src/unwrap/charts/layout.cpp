#include "unwrap/charts/layout.h"

#include "halflight/base/parallel.h"
#include "unwrap/charts/cluster.h"
#include "unwrap/charts/coarse.h"
#include "unwrap/charts/merge.h"
#include "unwrap/charts/split_triangles.h"

#include <cmath>
#include <functional>

namespace halflight::charts {
namespace {

/// Where the corners of triangles will about lie, or nothing.
using Guess = std::function<std::vector<dvec2>(const std::vector<uint32_t>& triangles)>;

/// What is known of the corners of `triangles`, which are some of `all`.
Start startOf(const std::vector<uint32_t>& triangles, const std::vector<uint32_t>& all, std::span<const dvec2> corners)
{
    Start start;
    if (corners.empty()) return start;
    start.corners.reserve(3 * triangles.size());
    std::size_t i = 0;
    for (const uint32_t t : triangles) {
        while (all[i] != t) ++i; // both ascend
        start.corners.insert(start.corners.end(), corners.begin() + std::ptrdiff_t(3 * i),
                             corners.begin() + std::ptrdiff_t(3 * i + 3));
    }
    return start;
}

/// Flattens connected sets of triangles into as many charts as it takes: where one folds or overlaps it is split, and
/// a single triangle always lies flat.
void flattenOrSplit(const Surface& surface, std::vector<std::vector<uint32_t>> waiting, const Guess& guess,
                    std::vector<Chart>& charts, const Progress& progress)
{
    std::vector<Start> starts(waiting.size());
    for (std::size_t i = 0; i < waiting.size(); ++i) {
        if (guess) starts[i].corners = guess(waiting[i]);
    }
    while (!waiting.empty() && !progress.cancelled()) {
        const std::vector<uint32_t> current = std::move(waiting.back());
        const Start start = std::move(starts.back());
        waiting.pop_back();
        starts.pop_back();
        Flattening flattening = flatten(surface, current, start);
        if (flattening.valid) {
            charts.push_back(std::move(flattening.chart));
            continue;
        }
        for (const std::vector<uint32_t>& half : splitTriangles(surface, current, flattening.seedA, flattening.seedB)) {
            for (std::vector<uint32_t>& piece : connectedPieces(surface, half)) {
                // When but a corner is cut off, the others stay where they are.
                const bool most = 3 * piece.size() > 2 * current.size();
                starts.push_back(startOf(piece, current, most ? flattening.corners : start.corners));
                starts.back().settled = most && !flattening.corners.empty();
                waiting.push_back(std::move(piece));
            }
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

namespace {

/// Larger meshes are cut into charts on a coarse copy.
constexpr std::size_t kLargeMesh = 200000;

Layout collect(const Surface& surface, std::vector<std::vector<Chart>> charts)
{
    Layout layout;
    layout.chartOfTriangle.assign(surface.triangleCount(), kNone);
    for (std::vector<Chart>& some : charts) {
        for (Chart& chart : some) {
            for (const uint32_t t : chart.triangles) layout.chartOfTriangle[t] = uint32_t(layout.charts.size());
            layout.area += chart.area;
            layout.charts.push_back(std::move(chart));
        }
    }
    return layout;
}

Layout layoutOf(const Surface& surface, std::span<const uint32_t> together, double texelMeters,
                const Progress& progress)
{
    const Regions regions = clusterTriangles(surface, together, progress);
    if (progress.cancelled()) return {};
    std::vector<std::vector<uint32_t>> members(regions.count);
    for (uint32_t t = 0; t < surface.triangleCount(); ++t) {
        if (regions.ofTriangle[t] != kNone) members[regions.ofTriangle[t]].push_back(t);
    }
    std::vector<std::vector<Chart>> charts(regions.count);
    parallelFor(regions.count, 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t r = begin; r < end; ++r)
            flattenOrSplit(surface, {std::move(members[r])}, {}, charts[r], progress);
    });
    if (progress.cancelled()) return {}; // some triangles are in no chart
    Layout layout = collect(surface, std::move(charts));
    mergeCharts(surface, layout.charts, layout.chartOfTriangle, texelMeters, progress);
    return layout;
}

/// Where a coarse chart puts the atoms that are its own: an affine map for each.
class AtomMaps {
public:
    AtomMaps(const CoarseSurface& coarse, const Layout& layout)
        : chartOfAtom(coarse.fanStart.size() - 1, kNone), maps_(chartOfAtom.size())
    {
        const Surface& surface = coarse.surface;
        std::vector<uint32_t> place(surface.triangleCount()); // in the chart's list
        for (const Chart& chart : layout.charts) {
            for (uint32_t i = 0; i < chart.triangles.size(); ++i) place[chart.triangles[i]] = i;
        }
        parallelFor(maps_.size(), 256, [&](std::size_t begin, std::size_t end) {
            for (std::size_t a = begin; a < end; ++a) {
                // A fan that was split after all goes where most of it is.
                double most = 0.0;
                for (uint32_t t = coarse.fanStart[a]; t < coarse.fanStart[a + 1]; ++t) {
                    double area = 0.0;
                    for (uint32_t s = coarse.fanStart[a]; s < coarse.fanStart[a + 1]; ++s)
                        area += layout.chartOfTriangle[s] == layout.chartOfTriangle[t] ? surface.areas[s] : 0.0;
                    if (!(area > most)) continue;
                    most = area;
                    chartOfAtom[a] = layout.chartOfTriangle[t];
                }
                if (chartOfAtom[a] != kNone) fit(coarse, layout.charts[chartOfAtom[a]], place, a);
            }
        });
    }

    [[nodiscard]] dvec2 at(uint32_t atom, dvec3 point) const
    {
        const Map& map = maps_[atom];
        const dvec3 p = point - map.center;
        return map.uv + dvec2(glm::dot(map.rowU, p), glm::dot(map.rowV, p));
    }

    std::vector<uint32_t> chartOfAtom;

private:
    struct Map {
        dvec3 center{0.0}, rowU{0.0}, rowV{0.0};
        dvec2 uv{0.0};
    };

    /// The mean of the gradients that the fan's triangles have.
    void fit(const CoarseSurface& coarse, const Chart& chart, const std::vector<uint32_t>& place, std::size_t atom)
    {
        const Surface& surface = coarse.surface;
        Map& map = maps_[atom];
        double area = 0.0;
        for (uint32_t t = coarse.fanStart[atom]; t < coarse.fanStart[atom + 1]; ++t) {
            const uint32_t i = place[t];
            if (i >= chart.triangles.size() || chart.triangles[i] != t) continue;
            const dvec3 p = surface.corner(t, 0), a = surface.corner(t, 1) - p, b = surface.corner(t, 2) - p;
            const dvec2 uv = chart.uv[chart.corners[3 * i]];
            const dvec2 ua = chart.uv[chart.corners[3 * i + 1]] - uv, ub = chart.uv[chart.corners[3 * i + 2]] - uv;
            // The gradient of a linear function on a triangle, times its double area.
            const dvec3 acrossA = glm::cross(surface.normals[t], a), acrossB = glm::cross(surface.normals[t], b);
            map.rowU += ub.x * acrossA - ua.x * acrossB;
            map.rowV += ub.y * acrossA - ua.y * acrossB;
            area += 2.0 * surface.areas[t];
            map.center = p;
            map.uv = uv;
        }
        map.rowU /= area;
        map.rowV /= area;
    }

    std::vector<Map> maps_;
};

/// Charts are found on a coarse copy and then flattened as they are.
Layout layoutOfLarge(const Surface& surface, double texelMeters, const Progress& progress)
{
    const CoarseSurface coarse = coarsen(surface, progress);
    if (progress.cancelled()) return {};
    // Boxes, leaves and the like: nothing to be gained where all is small pieces.
    if (2 * coarse.surface.triangleCount() > surface.triangleCount())
        return layoutOf(surface, {}, texelMeters, progress);
    std::vector<uint32_t> together(coarse.surface.triangleCount());
    for (std::size_t a = 0; a + 1 < coarse.fanStart.size(); ++a)
        std::fill(together.begin() + coarse.fanStart[a], together.begin() + coarse.fanStart[a + 1], coarse.fanStart[a]);
    const Layout rough = layoutOf(coarse.surface, together, texelMeters, progress);
    if (progress.cancelled()) return {};
    const AtomMaps maps(coarse, rough);
    std::vector<std::vector<uint32_t>> members(rough.charts.size() + 1); // the last: atoms that got into no chart
    for (uint32_t t = 0; t < surface.triangleCount(); ++t) {
        const uint32_t atom = coarse.atomOfTriangle[t];
        if (atom != kNone) members[std::min<std::size_t>(maps.chartOfAtom[atom], rough.charts.size())].push_back(t);
    }
    std::vector<std::vector<Chart>> charts(members.size());
    const auto guess = [&](const std::vector<uint32_t>& triangles) {
        std::vector<dvec2> corners;
        corners.reserve(3 * triangles.size());
        for (const uint32_t t : triangles) {
            for (int k = 0; k < 3; ++k) corners.push_back(maps.at(coarse.atomOfTriangle[t], surface.corner(t, k)));
        }
        return corners;
    };
    parallelFor(members.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t c = begin; c < end; ++c)
            flattenOrSplit(surface, connectedPieces(surface, members[c]), guess, charts[c], progress);
    });
    return collect(surface, std::move(charts));
}

} // namespace

Layout makeLayout(const Surface& surface, double texelMeters, const Progress& progress)
{
    return surface.triangleCount() > kLargeMesh ? layoutOfLarge(surface, texelMeters, progress)
                                                : layoutOf(surface, {}, texelMeters, progress);
}

} // namespace halflight::charts
