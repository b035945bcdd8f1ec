#include "unwrap/charts/outline.h"

#include <algorithm>

namespace halflight::charts {
namespace {

/// Andrew 1979, "Another efficient algorithm for convex hulls in two dimensions".
std::vector<dvec2> convexHull(std::span<const dvec2> points)
{
    std::vector<dvec2> sorted(points.begin(), points.end());
    const auto less = [](dvec2 a, dvec2 b) { return a.x != b.x ? a.x < b.x : a.y < b.y; };
    std::sort(sorted.begin(), sorted.end(), less);
    sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
    if (sorted.size() < 3) return sorted;
    std::vector<dvec2> hull(2 * sorted.size());
    std::size_t size = 0;
    const auto add = [&](dvec2 p, std::size_t least) {
        while (size >= least) {
            const dvec2 a = hull[size - 2], b = hull[size - 1];
            if ((b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x) > 0.0) break;
            --size;
        }
        hull[size++] = p;
    };
    for (const dvec2 p : sorted) add(p, 2);
    const std::size_t lower = size + 1;
    for (std::size_t i = sorted.size() - 1; i-- > 0;) add(sorted[i], lower);
    hull.resize(size - 1);
    return hull;
}

} // namespace

dvec2 smallestRectangleAxis(std::span<const dvec2> points)
{
    const std::vector<dvec2> hull = convexHull(points);
    dvec2 best(1.0, 0.0);
    double bestArea = 1e300;
    // Long hulls (discs) gain nothing from trying every edge.
    const std::size_t stride = std::max<std::size_t>(hull.size() / 256, 1);
    for (std::size_t i = 0; i < hull.size(); i += stride) {
        const dvec2 edge = hull[(i + 1) % hull.size()] - hull[i];
        const double length = glm::length(edge);
        if (!(length > 0.0)) continue;
        const dvec2 axis = edge / length;
        dvec2 least(1e300), most(-1e300);
        for (const dvec2 p : hull) {
            const dvec2 q(axis.x * p.x + axis.y * p.y, axis.x * p.y - axis.y * p.x);
            least = glm::min(least, q);
            most = glm::max(most, q);
        }
        const double area = (most.x - least.x) * (most.y - least.y);
        if (area < bestArea * (1.0 - 1e-9)) {
            bestArea = area;
            best = axis;
        }
    }
    return best;
}

} // namespace halflight::charts
