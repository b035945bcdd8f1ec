#include "scene/model/closed_part.h"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <tuple>
#include <vector>

namespace halflight {
namespace {

/// For each vertex the first of those at its place.
std::vector<uint32_t> placesOf(const std::vector<vec3>& positions)
{
    std::vector<uint32_t> order(positions.size());
    std::iota(order.begin(), order.end(), 0u);
    const auto key = [&](uint32_t v) { return std::tuple(positions[v].x, positions[v].y, positions[v].z); };
    std::sort(order.begin(), order.end(),
              [&](uint32_t a, uint32_t b) { return key(a) != key(b) ? key(a) < key(b) : a < b; });
    std::vector<uint32_t> places(positions.size());
    for (std::size_t i = 0; i < order.size(); ++i)
        places[order[i]] = i > 0 && key(order[i]) == key(order[i - 1]) ? places[order[i - 1]] : order[i];
    return places;
}

struct Edge {
    uint32_t low;
    uint32_t high;
    int direction; ///< 1 from low to high, -1 the other way
};

} // namespace

bool isClosed(const MeshPart& part)
{
    const std::vector<uint32_t> places = placesOf(part.positions);
    std::vector<Edge> edges;
    double sixVolumes = 0.0;
    for (std::size_t i = 0; i + 2 < part.indices.size(); i += 3) {
        const uint32_t corners[] = {places[part.indices[i]], places[part.indices[i + 1]], places[part.indices[i + 2]]};
        for (int k = 0; k < 3; ++k) {
            const uint32_t a = corners[k];
            const uint32_t b = corners[(k + 1) % 3];
            if (a != b) edges.push_back({std::min(a, b), std::max(a, b), a < b ? 1 : -1});
        }
        const glm::dvec3 origin(part.positions[places[part.indices[0]]]);
        const auto from = [&](uint32_t v) { return glm::dvec3(part.positions[v]) - origin; };
        sixVolumes += glm::dot(from(corners[0]), glm::cross(from(corners[1]), from(corners[2])));
    }
    const auto same = [](const Edge& a, const Edge& b) { return a.low == b.low && a.high == b.high; };
    std::sort(edges.begin(), edges.end(),
              [](const Edge& a, const Edge& b) { return std::tie(a.low, a.high) < std::tie(b.low, b.high); });
    for (std::size_t i = 0; i < edges.size();) {
        int balance = 0;
        std::size_t end = i;
        for (; end < edges.size() && same(edges[end], edges[i]); ++end) balance += edges[end].direction;
        if (balance != 0) return false;
        i = end;
    }
    return sixVolumes > 0.0;
}

} // namespace halflight
