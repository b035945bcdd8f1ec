#include "bake/sides/hidden_sides.h"

#include "bake/geometry/surfaces_along.h"
#include "bake/seams/seams.h"

#include "halflight/base/parallel.h"
#include "unwrap/cuts/crossing_points.h"

#include <algorithm>
#include <memory>

namespace halflight {
namespace {

bool isBlocked(const std::optional<vec2>& surfaces)
{
    return surfaces.has_value();
}

/// By point of pointsAround(), 1 where the surface goes on below it, and it lies outside geometry.
Result<std::vector<uint8_t>> findOpen(const Integrator& integrator, const std::vector<uint32_t>& firstTriangle,
                                      std::span<const CrossingPoint> crossings)
{
    std::vector<SurfacePoint> points(crossings.size() * kPointsAround);
    std::vector<Segment> down(points.size());
    forEachIndex(crossings.size(), [&](std::size_t c) {
        const CrossingPoint& crossing = crossings[c];
        const uint32_t triangle = firstTriangle[std::size_t(crossing.object)] + crossing.triangle;
        const float depth = 2.0f * kSightRise * crossing.texelMeters;
        std::size_t i = c * kPointsAround;
        for (const vec3 point : pointsAround(crossing)) {
            points[i] = {point, crossing.normal, crossing.normal, triangle, vec2(0.0f)};
            down[i++] = {point, point - depth * crossing.normal};
        }
    });
    // One ray tells whether there is surface below; whether a point lies outside takes many.
    const Result<SurfacesAlong> below = surfacesAlong(integrator, down);
    if (!below) return below.error();
    std::vector<uint8_t> open(points.size(), 0);
    for (std::size_t i = 0; i < points.size(); ++i) open[i] = isBlocked((*below)[i]) ? 1 : 0;
    if (Status s = integrator.findValidPoints(points, open); !s) return s.error();
    return open;
}

/// Lines of sight between open points of both sides.
struct SightLines {
    std::vector<Segment> low;
    std::vector<std::size_t> ofCrossing;
};

SightLines sightLines(std::span<const CrossingPoint> crossings, const std::vector<uint8_t>& open)
{
    SightLines lines;
    for (std::size_t c = 0; c < crossings.size(); ++c) {
        const auto points = pointsAround(crossings[c]);
        const std::size_t half = points.size() / 2;
        const std::size_t first = c * points.size();
        for (std::size_t a = 0; a < half; ++a) {
            for (std::size_t b = half; b < points.size(); ++b) {
                if (open[first + a] == 0 || open[first + b] == 0) continue;
                lines.low.push_back({points[a], points[b]});
                lines.ofCrossing.push_back(c);
            }
        }
    }
    return lines;
}

std::vector<uint32_t> firstTriangles(const Scene& scene, const BakeGeometry& geometry)
{
    std::vector<uint32_t> first(scene.objects.size(), ~0u);
    for (const BakeGeometry::Part& part : geometry.parts) {
        uint32_t& of = first[std::size_t(part.object)];
        of = std::min(of, part.firstTriangle);
    }
    return first;
}

/// By crossing, 1 where a surface hides its sides from one another.
Result<std::vector<uint8_t>> findHidden(const Integrator& integrator, const std::vector<uint32_t>& firstTriangle,
                                        std::span<const CrossingPoint> crossings)
{
    const Result<std::vector<uint8_t>> open = findOpen(integrator, firstTriangle, crossings);
    if (!open) return open.error();
    const SightLines lines = sightLines(crossings, *open);
    const Result<SurfacesAlong> low = surfacesAlong(integrator, lines.low);
    if (!low) return low.error();
    // Only where a low line is blocked, a high one is asked for: what is in the way may be an edge.
    std::vector<Segment> high;
    std::vector<std::size_t> ofHigh;
    for (std::size_t i = 0; i < lines.low.size(); ++i) {
        if (!isBlocked((*low)[i])) continue;
        const CrossingPoint& crossing = crossings[lines.ofCrossing[i]];
        const vec3 up = kHiddenHeight * crossing.texelMeters * crossing.rise;
        high.push_back({lines.low[i].from + up, lines.low[i].to + up});
        ofHigh.push_back(lines.ofCrossing[i]);
    }
    const Result<SurfacesAlong> blocked = surfacesAlong(integrator, high);
    if (!blocked) return blocked.error();
    std::vector<uint8_t> hidden(crossings.size(), 0);
    for (std::size_t i = 0; i < high.size(); ++i)
        if (isBlocked((*blocked)[i])) hidden[ofHigh[i]] = 1;
    return hidden;
}

} // namespace

CrossingTest hiddenSidesTest(SourceTree& tree)
{
    return [&tree](const Scene& scene, std::span<const CrossingPoint> crossings) {
        std::vector<uint8_t> none(crossings.size(), 0);
        const Integrator* integrator = tree.integratorOf(scene);
        if (integrator == nullptr) return none;
        Result<std::vector<uint8_t>> hidden =
            findHidden(*integrator, firstTriangles(scene, tree.geometryOf(scene)), crossings);
        if (hidden) return std::move(*hidden);
        tree.fail(hidden.error());
        return none;
    };
}

Status dropHiddenSeams(const Integrator& integrator, std::vector<SeamSample>& seams)
{
    std::vector<Segment> sight;
    sight.reserve(seams.size());
    for (const SeamSample& seam : seams) sight.push_back(seam.sight);
    const Result<SurfacesAlong> surfaces = surfacesAlong(integrator, sight);
    if (!surfaces) return surfaces.error();
    std::size_t kept = 0;
    for (std::size_t i = 0; i < seams.size(); ++i) {
        if (!isBlocked((*surfaces)[i])) seams[kept++] = seams[i];
    }
    seams.resize(kept);
    return {};
}

} // namespace halflight
