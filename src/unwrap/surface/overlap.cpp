#include "unwrap/surface/overlap.h"

#include <algorithm>
#include <cmath>

namespace halflight::charts {
namespace {

/// Separating axis test: how deep two triangles reach into one another along their six edge normals.
bool overlap(const FlatTriangle& a, const FlatTriangle& b, double tolerance)
{
    for (const FlatTriangle* owner : {&a, &b}) {
        for (int k = 0; k < 3; ++k) {
            const dvec2 edge = owner->corners[(k + 1) % 3] - owner->corners[k];
            const double length = glm::length(edge);
            if (!(length > 0.0)) continue;
            const dvec2 normal = dvec2(-edge.y, edge.x) / length;
            double lowA = 1e300, highA = -1e300, lowB = 1e300, highB = -1e300;
            for (int i = 0; i < 3; ++i) {
                const double pa = glm::dot(normal, a.corners[i]), pb = glm::dot(normal, b.corners[i]);
                lowA = std::min(lowA, pa);
                highA = std::max(highA, pa);
                lowB = std::min(lowB, pb);
                highB = std::max(highB, pb);
            }
            if (std::min(highA, highB) - std::max(lowA, lowB) <= tolerance) return false;
        }
    }
    return true;
}

} // namespace

std::optional<std::pair<uint32_t, uint32_t>> findOverlap(std::span<const FlatTriangle> triangles, double tolerance)
{
    const std::size_t count = triangles.size();
    if (count < 2) return std::nullopt;
    const auto low = [&](std::size_t t) {
        const auto& c = triangles[t].corners;
        return glm::min(c[0], glm::min(c[1], c[2]));
    };
    const auto high = [&](std::size_t t) {
        const auto& c = triangles[t].corners;
        return glm::max(c[0], glm::max(c[1], c[2]));
    };
    if (count <= 24) {
        for (uint32_t a = 0; a < count; ++a) {
            for (uint32_t b = a + 1; b < count; ++b) {
                if (overlap(triangles[a], triangles[b], tolerance)) return std::pair{a, b};
            }
        }
        return std::nullopt;
    }
    // A uniform grid of about one cell per triangle. A pair is tested in the first cell that both boxes share.
    dvec2 least(1e300), most(-1e300);
    for (std::size_t t = 0; t < count; ++t) {
        least = glm::min(least, low(t));
        most = glm::max(most, high(t));
    }
    const dvec2 extent = glm::max(most - least, dvec2(1e-300));
    const double cell = std::max(std::sqrt(extent.x * extent.y / double(count)), std::max(extent.x, extent.y) / 4096.0);
    const ivec2 cells(glm::clamp(extent / cell, dvec2(0.0), dvec2(4095.0)) + 1.0);
    const auto cellOf = [&](dvec2 p) { return ivec2(glm::clamp((p - least) / cell, dvec2(0.0), dvec2(cells - 1))); };
    std::vector<uint32_t> start(std::size_t(cells.x) * std::size_t(cells.y) + 1, 0);
    const auto forCells = [&](std::size_t t, auto visit) {
        const ivec2 from = cellOf(low(t)), to = cellOf(high(t));
        for (int y = from.y; y <= to.y; ++y) {
            for (int x = from.x; x <= to.x; ++x) visit(std::size_t(y) * std::size_t(cells.x) + std::size_t(x));
        }
    };
    for (std::size_t t = 0; t < count; ++t) forCells(t, [&](std::size_t c) { ++start[c + 1]; });
    for (std::size_t c = 1; c < start.size(); ++c) start[c] += start[c - 1];
    std::vector<uint32_t> items(start.back()), fill(start.begin(), start.end() - 1);
    for (std::size_t t = 0; t < count; ++t) forCells(t, [&](std::size_t c) { items[fill[c]++] = uint32_t(t); });
    for (std::size_t c = 0; c + 1 < start.size(); ++c) {
        for (uint32_t i = start[c]; i < start[c + 1]; ++i) {
            const dvec2 lowA = low(items[i]), highA = high(items[i]);
            for (uint32_t j = i + 1; j < start[c + 1]; ++j) {
                const dvec2 lowBoth = glm::max(lowA, low(items[j])), highBoth = glm::min(highA, high(items[j]));
                if (lowBoth.x >= highBoth.x || lowBoth.y >= highBoth.y) continue;
                const ivec2 first = cellOf(lowBoth);
                if (std::size_t(first.y) * std::size_t(cells.x) + std::size_t(first.x) != c) continue;
                if (overlap(triangles[items[i]], triangles[items[j]], tolerance)) return std::pair{items[i], items[j]};
            }
        }
    }
    return std::nullopt;
}

} // namespace halflight::charts
