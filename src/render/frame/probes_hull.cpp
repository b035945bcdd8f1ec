// The nearest point on a set of triangles, by a tree of boxes.
#include "render/frame/probes_mesh.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace halflight {
namespace {

constexpr uint32_t kLeafFaces = 4;

double squared(const glm::dvec3& v)
{
    return glm::dot(v, v);
}

double distanceSquared(const glm::dvec3& low, const glm::dvec3& high, const glm::dvec3& point)
{
    return squared(glm::max(glm::max(low - point, point - high), glm::dvec3(0.0)));
}

/// Share of the way from a to b at the point nearest to the origin.
double alongEdge(const glm::dvec3& a, const glm::dvec3& b)
{
    const glm::dvec3 ab = b - a;
    const double length = squared(ab);
    return length > 0.0 ? glm::clamp(-glm::dot(a, ab) / length, 0.0, 1.0) : 0.0;
}

/// Barycentric coordinates of the triangle's point nearest to the origin: the perpendicular foot where it lies inside,
/// or else the best of the edges.
std::array<double, 3> nearestOfTriangle(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c)
{
    const glm::dvec3 normal = glm::cross(b - a, c - a);
    const std::array<double, 3> part = {glm::dot(normal, glm::cross(b, c)), glm::dot(normal, glm::cross(c, a)),
                                        glm::dot(normal, glm::cross(a, b))};
    const double sum = squared(normal);
    if (part[0] >= 0.0 && part[1] >= 0.0 && part[2] >= 0.0 && sum > 0.0) {
        const double total = part[0] + part[1] + part[2];
        return {part[0] / total, part[1] / total, part[2] / total};
    }
    const std::array<glm::dvec3, 3> v = {a, b, c};
    std::array<double, 3> best{1.0, 0.0, 0.0};
    double bestDistance = kInfinity;
    for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t j = (i + 1) % 3;
        const double t = alongEdge(v[i], v[j]);
        const double distance = squared(v[i] + t * (v[j] - v[i]));
        if (distance >= bestDistance) continue;
        bestDistance = distance;
        best = {};
        best[i] = 1.0 - t;
        best[j] = t;
    }
    return best;
}

} // namespace

void HullFaces::build(std::vector<Face> faces, std::span<const glm::dvec3> vertices)
{
    faces_ = std::move(faces);
    nodes_.clear();
    if (faces_.empty()) return;
    nodes_.push_back({});
    nodes_[0].end = uint32_t(faces_.size());
    split(0, vertices);
}

void HullFaces::split(std::size_t node, std::span<const glm::dvec3> vertices)
{
    const uint32_t begin = nodes_[node].begin;
    const uint32_t end = nodes_[node].end;
    glm::dvec3 low(kInfinity);
    glm::dvec3 high(-kInfinity);
    for (uint32_t i = begin; i < end; ++i) {
        for (const uint32_t v : faces_[i].vertex) {
            low = glm::min(low, vertices[v]);
            high = glm::max(high, vertices[v]);
        }
    }
    nodes_[node].low = low;
    nodes_[node].high = high;
    if (end - begin <= kLeafFaces) return;

    const glm::dvec3 size = high - low;
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const auto key = [&](const Face& f) {
        return vertices[f.vertex[0]][axis] + vertices[f.vertex[1]][axis] + vertices[f.vertex[2]][axis];
    };
    const uint32_t middle = begin + (end - begin) / 2;
    std::sort(faces_.begin() + begin, faces_.begin() + end, [&](const Face& a, const Face& b) {
        const double ka = key(a);
        const double kb = key(b);
        return ka < kb || (ka == kb && a.vertex < b.vertex);
    });
    const std::size_t left = nodes_.size();
    nodes_.push_back({});
    nodes_[left].begin = begin;
    nodes_[left].end = middle;
    split(left, vertices);
    const std::size_t right = nodes_.size();
    nodes_[node].right = uint32_t(right);
    nodes_.push_back({});
    nodes_[right].begin = middle;
    nodes_[right].end = end;
    split(right, vertices);
}

HullFaces::Nearest HullFaces::nearest(glm::dvec3 point, std::span<const glm::dvec3> vertices) const
{
    Nearest best;
    double bestDistance = kInfinity;
    std::array<uint32_t, 64> stack{}; // deeper than any median split of 2^32 faces
    std::size_t depth = 0;
    if (!nodes_.empty()) stack[depth++] = 0;
    while (depth > 0) {
        const uint32_t index = stack[--depth];
        const Node& node = nodes_[index];
        if (distanceSquared(node.low, node.high, point) >= bestDistance) continue;
        if (node.right == 0) {
            for (uint32_t i = node.begin; i < node.end; ++i) {
                const auto& v = faces_[i].vertex;
                const glm::dvec3 a = vertices[v[0]] - point;
                const glm::dvec3 b = vertices[v[1]] - point;
                const glm::dvec3 c = vertices[v[2]] - point;
                const std::array<double, 3> w = nearestOfTriangle(a, b, c);
                const double distance = squared(w[0] * a + w[1] * b + w[2] * c);
                if (distance >= bestDistance) continue;
                bestDistance = distance;
                best = {i, w};
            }
            continue;
        }
        uint32_t nearer = index + 1;
        uint32_t farther = node.right;
        if (distanceSquared(nodes_[farther].low, nodes_[farther].high, point) <
            distanceSquared(nodes_[nearer].low, nodes_[nearer].high, point))
            std::swap(nearer, farther);
        stack[depth++] = farther;
        stack[depth++] = nearer;
    }
    return best;
}

} // namespace halflight
