#include "unwrap/charts/chart.h"

#include "unwrap/charts/arap.h"
#include "unwrap/charts/folds.h"
#include "unwrap/charts/outline.h"

#include <cmath>

namespace halflight::charts {
namespace {

/// Charts whose normals all stay this close to their mean are projected: the stretch is below 3 %.
constexpr double kProjectionCosine = 0.97;

/// L2 stretch of Sander, Snyder, Gortler and Hoppe 2001, "Texture Mapping Progressive Meshes", for a flattening whose
/// area is the surface's.
double stretchOf(const Piece& piece, const std::vector<dvec2>& uv)
{
    double sum = 0.0;
    for (std::size_t t = 0; t < piece.triangles.size(); ++t) {
        const dvec2 a = uv[piece.corners[3 * t]], b = uv[piece.corners[3 * t + 1]], c = uv[piece.corners[3 * t + 2]];
        const dvec3 pa = piece.positions[piece.corners[3 * t]], pb = piece.positions[piece.corners[3 * t + 1]];
        const dvec3 pc = piece.positions[piece.corners[3 * t + 2]];
        const double doubleArea = doubleAreaOf(piece, uv, t);
        const dvec3 alongU = (pa * (b.y - c.y) + pb * (c.y - a.y) + pc * (a.y - b.y)) / doubleArea;
        const dvec3 alongV = (pa * (c.x - b.x) + pb * (a.x - c.x) + pc * (b.x - a.x)) / doubleArea;
        sum += piece.surface.areas[piece.triangles[t]] * 0.5 * (glm::dot(alongU, alongU) + glm::dot(alongV, alongV));
    }
    return std::sqrt(sum / piece.area);
}

/// Scales to the surface's area and turns into the smallest rectangle.
void settle(const Piece& piece, std::vector<dvec2>& uv, Chart& chart)
{
    double flatArea = 0.0;
    for (std::size_t t = 0; t < piece.triangles.size(); ++t) flatArea += 0.5 * doubleAreaOf(piece, uv, t);
    const double scale = std::sqrt(piece.area / flatArea);
    for (dvec2& p : uv) p *= scale;
    const dvec2 axis = smallestRectangleAxis(uv);
    dvec2 least(1e300), most(-1e300);
    for (dvec2& p : uv) {
        p = {axis.x * p.x + axis.y * p.y, axis.x * p.y - axis.y * p.x};
        least = glm::min(least, p);
        most = glm::max(most, p);
    }
    for (dvec2& p : uv) p -= least;
    chart.size = most - least;
    chart.stretch = stretchOf(piece, uv);
}

/// The triangle that is farthest from this one in direction and place, for splitting.
uint32_t farthest(const Piece& piece, uint32_t from)
{
    const Surface& surface = piece.surface;
    uint32_t best = kNone;
    double bestDistance = -1.0;
    for (const uint32_t t : piece.triangles) {
        if (t == from) continue;
        const double bent = 1.0 - glm::dot(surface.normals[t], surface.normals[from]);
        const double apart = glm::distance(surface.centroid(t), surface.centroid(from));
        const double distance = apart / std::sqrt(piece.area) + 2.0 * bent;
        if (distance > bestDistance) {
            bestDistance = distance;
            best = t;
        }
    }
    return best;
}

} // namespace

Flattening flatten(const Surface& surface, std::vector<uint32_t> triangles, const Start& start)
{
    const Piece piece(surface, std::move(triangles));
    Flattening result;
    const bool flat = piece.leastCosine >= kProjectionCosine || piece.triangles.size() == 1;
    const bool keeps = start.settled && !start.corners.empty() && !flat;
    std::vector<dvec2> uv = flat    ? project(piece)
                            : keeps ? startingPoint(piece, start.corners)
                                    : relax(piece, start.corners);
    uint32_t fold = findFold(piece, uv);
    if (!flat && fold != kNone) {
        unfold(piece, uv);
        fold = findFold(piece, uv);
    }
    const auto fail = [&](uint32_t a, uint32_t b) {
        result.seedA = a;
        result.seedB = b;
        return result;
    };
    if (!flat && fold != kNone && piece.leastCosine > 0.3) {
        uv = project(piece);
        fold = findFold(piece, uv);
    }
    if (piece.triangles.size() > 1) {
        if (fold != kNone) return fail(piece.triangles[fold], farthest(piece, piece.triangles[fold]));
        if (const auto overlap = findSelfOverlap(piece, uv)) {
            for (const uint32_t vertex : piece.corners) result.corners.push_back(uv[vertex]);
            return fail(piece.triangles[overlap->first], piece.triangles[overlap->second]);
        }
    }
    Chart& chart = result.chart;
    settle(piece, uv, chart);
    chart.area = piece.area;
    chart.perimeter = piece.perimeter;
    chart.triangles = piece.triangles;
    chart.corners = piece.corners;
    chart.uv = std::move(uv);
    result.valid = true;
    return result;
}

} // namespace halflight::charts
