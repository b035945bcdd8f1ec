#include "unwrap/charts/split_triangles.h"

#include "unwrap/charts/piece.h"

#include <cmath>
#include <queue>

namespace halflight::charts {

std::array<std::vector<uint32_t>, 2> splitTriangles(const Surface& surface, const std::vector<uint32_t>& triangles,
                                                    uint32_t seedA, uint32_t seedB)
{
    // Dijkstra from both seeds at once; a bend counts like a distance of the chart's own size.
    double area = 0.0;
    for (const uint32_t t : triangles) area += surface.areas[t];
    const double size = std::sqrt(area);
    struct Front {
        double distance;
        uint32_t triangle, side;
        bool operator<(const Front& other) const
        {
            return distance != other.distance ? distance > other.distance : triangle > other.triangle;
        }
    };
    std::priority_queue<Front> queue;
    std::vector<uint8_t> side(triangles.size(), 2);
    queue.push({0.0, seedA, 0});
    queue.push({0.0, seedB, 1});
    while (!queue.empty()) {
        const Front front = queue.top();
        queue.pop();
        uint8_t& mine = side[placeAmong(triangles, front.triangle)];
        if (mine != 2) continue;
        mine = uint8_t(front.side);
        for (uint32_t k = 0; k < 3; ++k) {
            const uint32_t half = surface.neighbors[3 * front.triangle + k];
            if (half == kNone) continue;
            const uint32_t other = half / 3, index = placeAmong(triangles, other);
            if (index == kNone || side[index] != 2) continue;
            const double bend = 1.0 - glm::dot(surface.normals[front.triangle], surface.normals[other]);
            const double step = glm::distance(surface.centroid(front.triangle), surface.centroid(other)) + size * bend;
            queue.push({front.distance + step, other, front.side});
        }
    }
    std::array<std::vector<uint32_t>, 2> halves;
    for (std::size_t i = 0; i < triangles.size(); ++i) halves[side[i] == 1 ? 1 : 0].push_back(triangles[i]);
    return halves;
}

std::vector<std::vector<uint32_t>> connectedPieces(const Surface& surface, const std::vector<uint32_t>& triangles)
{
    std::vector<char> seen(triangles.size(), 0);
    std::vector<std::vector<uint32_t>> pieces;
    for (std::size_t start = 0; start < triangles.size(); ++start) {
        if (seen[start]) continue;
        std::vector<uint32_t>& piece = pieces.emplace_back();
        piece.push_back(triangles[start]);
        seen[start] = 1;
        for (std::size_t i = 0; i < piece.size(); ++i) {
            for (uint32_t k = 0; k < 3; ++k) {
                const uint32_t half = surface.neighbors[3 * piece[i] + k];
                const uint32_t index = half == kNone ? kNone : placeAmong(triangles, half / 3);
                if (index == kNone || seen[index]) continue;
                seen[index] = 1;
                piece.push_back(half / 3);
            }
        }
        std::sort(piece.begin(), piece.end());
    }
    return pieces;
}

} // namespace halflight::charts
