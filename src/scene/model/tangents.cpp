#include "scene/model/tangents.h"

#include "halflight/base/mathematics.h"
#include "scene/model/geometry.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <tuple>
#include <unordered_map>

namespace halflight {

namespace {

constexpr uint32_t kNone = ~0u;
constexpr float kTiny = std::numeric_limits<float>::min();

// Corners are numbered 3 * triangle + k; edge c leads from corner c to the next corner of its triangle.
uint32_t nextCorner(uint32_t corner)
{
    return corner % 3 == 2 ? corner - 2 : corner + 1;
}
uint32_t previousCorner(uint32_t corner)
{
    return corner % 3 == 0 ? corner + 2 : corner - 1;
}

struct Triangle {
    vec3 uDirection{0.0f};     // in which u grows, unit; zero where the triangle has no texture area
    bool mirrored = false;     // the picture is seen from behind
    bool hasTexture = false;   // neither the picture nor the surface degenerates to a line
    bool isDegenerate = false; // two corners in one place
    bool grouped = false;      // some corner is in a group: a triangle without texture has taken its side
};

class TangentSpace {
public:
    TangentSpace(const MeshPart& part, const std::vector<vec2>& uv) : part_(part), uv_(uv)
    {
        weld();
        measureTriangles();
        findNeighbours();
        makeGroups();
    }

    /// Tangent of each corner.
    std::vector<vec4> cornerTangents() const
    {
        std::vector<vec4> ofGroup(groups_.size());
        for (std::size_t g = 0; g < groups_.size(); ++g) ofGroup[g] = evaluate(groups_[g]);
        std::unordered_map<uint32_t, uint32_t> groupAt; // by welded vertex, for degenerate triangles
        for (uint32_t c = 0; c < group_.size(); ++c) {
            if (group_[c] != kNone) groupAt.try_emplace(welded_[c], group_[c]);
        }
        std::vector<vec4> tangents(group_.size());
        for (uint32_t c = 0; c < group_.size(); ++c) {
            uint32_t group = group_[c];
            if (group == kNone) {
                const auto it = groupAt.find(welded_[c]);
                if (it != groupAt.end()) group = it->second;
            }
            tangents[c] = group != kNone ? ofGroup[group] : vec4(anySide(normal(c)), 1.0f);
        }
        return tangents;
    }

    /// Any unit vector in the plane of a normal.
    static vec3 anySide(vec3 n)
    {
        const vec3 side = glm::cross(n, std::abs(n.x) < 0.9f ? vec3(1, 0, 0) : vec3(0, 1, 0));
        const float length = glm::length(side);
        return length > 0.0f ? side / length : vec3(1, 0, 0);
    }

private:
    /// The corners around one vertex that edges join and whose triangles show the picture from one side.
    struct Group {
        std::vector<uint32_t> corners;
        bool mirrored = false;
    };

    [[nodiscard]] const vec3& position(uint32_t corner) const { return part_.positions[part_.indices[corner]]; }
    [[nodiscard]] const vec3& normal(uint32_t corner) const { return part_.normals[part_.indices[corner]]; }
    [[nodiscard]] const vec2& texture(uint32_t corner) const { return uv_[part_.indices[corner]]; }

    // Vertices that agree in position, normal and texture coordinate are one.
    void weld()
    {
        using Key = std::array<uint32_t, 8>;
        struct KeyHash {
            std::size_t operator()(const Key& key) const
            {
                uint64_t hash = 0xcbf29ce484222325u; // FNV-1a
                for (const uint32_t word : key) hash = (hash ^ word) * 0x100000001b3u;
                return std::size_t(hash ^ hash >> 29);
            }
        };
        std::unordered_map<Key, uint32_t, KeyHash> vertexOf;
        vertexOf.reserve(part_.positions.size());
        std::vector<uint32_t> weldedVertex(part_.positions.size());
        for (uint32_t v = 0; v < part_.positions.size(); ++v) {
            const vec3 p = part_.positions[v] + 0.0f; // no negative zeros
            const vec3 n = part_.normals[v] + 0.0f;
            const vec2 t = uv_[v] + 0.0f;
            const std::array<float, 8> numbers = {p.x, p.y, p.z, n.x, n.y, n.z, t.x, t.y};
            Key key;
            std::memcpy(key.data(), numbers.data(), sizeof key);
            weldedVertex[v] = vertexOf.try_emplace(key, v).first->second;
        }
        welded_.resize(part_.indices.size());
        for (std::size_t c = 0; c < welded_.size(); ++c) welded_[c] = weldedVertex[part_.indices[c]];
    }

    // First derivatives of the position by u and v on each triangle.
    void measureTriangles()
    {
        triangles_.resize(part_.triangleCount());
        for (uint32_t t = 0; t < triangles_.size(); ++t) {
            Triangle& triangle = triangles_[t];
            const vec3& p = position(3 * t);
            triangle.isDegenerate =
                p == position(3 * t + 1) || p == position(3 * t + 2) || position(3 * t + 1) == position(3 * t + 2);
            const vec3 e1 = position(3 * t + 1) - p;
            const vec3 e2 = position(3 * t + 2) - p;
            const vec2 d1 = texture(3 * t + 1) - texture(3 * t);
            const vec2 d2 = texture(3 * t + 2) - texture(3 * t);
            const float area = d1.x * d2.y - d1.y * d2.x; // signed, twice
            triangle.mirrored = area > 0.0f; // v points down: a picture seen from the front turns the other way round
            if (!(std::abs(area) > kTiny)) continue;
            const vec3 du = e1 * d2.y - e2 * d1.y; // times the area
            const vec3 dv = e2 * d1.x - e1 * d2.x;
            const float length = glm::length(du);
            if (length > kTiny) triangle.uDirection = du * ((triangle.mirrored ? 1.0f : -1.0f) / length);
            triangle.hasTexture = length / std::abs(area) > kTiny && glm::length(dv) / std::abs(area) > kTiny;
        }
    }

    // Two triangles are neighbours where their edges run in opposite directions between the same vertices. Where more
    // than two meet, the first two are.
    void findNeighbours()
    {
        struct Edge {
            uint32_t low, high, corner;
        };
        std::vector<Edge> edges;
        for (uint32_t c = 0; c < welded_.size(); ++c) {
            if (triangles_[c / 3].isDegenerate) continue;
            const uint32_t a = welded_[c];
            const uint32_t b = welded_[nextCorner(c)];
            edges.push_back({std::min(a, b), std::max(a, b), c});
        }
        std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) {
            return std::tie(a.low, a.high, a.corner) < std::tie(b.low, b.high, b.corner);
        });
        neighbour_.assign(welded_.size(), kNone);
        for (std::size_t i = 0; i < edges.size(); ++i) {
            if (neighbour_[edges[i].corner] != kNone) continue;
            for (std::size_t k = i + 1;
                 k < edges.size() && edges[k].low == edges[i].low && edges[k].high == edges[i].high; ++k) {
                const bool opposite = welded_[edges[k].corner] != welded_[edges[i].corner];
                if (!opposite || neighbour_[edges[k].corner] != kNone) continue;
                neighbour_[edges[i].corner] = edges[k].corner;
                neighbour_[edges[k].corner] = edges[i].corner;
                break;
            }
        }
    }

    // Walks from each corner that has no group yet around its vertex.
    void makeGroups()
    {
        group_.assign(welded_.size(), kNone);
        std::vector<uint32_t> stack;
        for (uint32_t first = 0; first < welded_.size(); ++first) {
            const Triangle& start = triangles_[first / 3];
            if (group_[first] != kNone || start.isDegenerate || !start.hasTexture) continue;
            const auto index = uint32_t(groups_.size());
            Group group;
            group.mirrored = start.mirrored;
            stack.assign(1, first);
            while (!stack.empty()) {
                const uint32_t corner = stack.back();
                stack.pop_back();
                Triangle& triangle = triangles_[corner / 3];
                if (group_[corner] != kNone) continue;
                if (!triangle.hasTexture && !triangle.grouped) triangle.mirrored = group.mirrored;
                if (triangle.mirrored != group.mirrored) continue;
                triangle.grouped = true;
                group_[corner] = index;
                group.corners.push_back(corner);
                // The edge into the corner first, so that the edge out of it is walked before.
                const uint32_t before = neighbour_[previousCorner(corner)];
                const uint32_t after = neighbour_[corner];
                if (before != kNone) stack.push_back(before); // opposite: it starts at this vertex
                if (after != kNone) stack.push_back(nextCorner(after));
            }
            groups_.push_back(std::move(group));
        }
    }

    // The mean of the triangles' directions in the plane of the normal, by the angle that each has there.
    [[nodiscard]] vec4 evaluate(const Group& group) const
    {
        const vec3 n = normal(group.corners[0]);
        const auto inPlane = [&](vec3 v) {
            const vec3 projected = v - n * glm::dot(n, v);
            const float length = glm::length(projected);
            return length > kTiny ? projected / length : vec3(0.0f);
        };
        vec3 sum(0.0f);
        for (const uint32_t c : group.corners) {
            const vec3 a = inPlane(position(previousCorner(c)) - position(c));
            const vec3 b = inPlane(position(nextCorner(c)) - position(c));
            sum += math::acos(std::clamp(glm::dot(a, b), -1.0f, 1.0f)) * inPlane(triangles_[c / 3].uDirection);
        }
        const float length = glm::length(sum);
        return {length > kTiny ? sum / length : anySide(n), group.mirrored ? -1.0f : 1.0f};
    }

    const MeshPart& part_;
    const std::vector<vec2>& uv_;
    std::vector<uint32_t> welded_;    // by corner: the first vertex that is the same
    std::vector<uint32_t> neighbour_; // by edge: the neighbour's edge
    std::vector<uint32_t> group_;     // by corner
    std::vector<Triangle> triangles_;
    std::vector<Group> groups_;
};

} // namespace

void makeTangents(MeshPart& part, const std::vector<vec2>& uv, const mat2& uvFromTexCoord)
{
    std::vector<vec2> mapped(uv.size());
    std::transform(uv.begin(), uv.end(), mapped.begin(), [&](vec2 t) { return uvFromTexCoord * t; });
    const std::vector<vec4> ofCorner = TangentSpace(part, mapped).cornerTangents();

    // A vertex has the tangent of its first corner; corners with others get copies of it.
    std::vector<uint32_t> kept(part.positions.size());
    for (std::size_t v = 0; v < kept.size(); ++v) kept[v] = uint32_t(v);
    std::vector<vec4> tangents(kept.size(), vec4(0.0f));
    std::vector<bool> has(kept.size(), false);
    std::map<std::pair<uint32_t, std::array<float, 4>>, uint32_t> copies;
    for (std::size_t c = 0; c < part.indices.size(); ++c) {
        const uint32_t v = part.indices[c];
        const vec4 t = ofCorner[c];
        if (!has[v]) {
            has[v] = true;
            tangents[v] = t;
        }
        if (tangents[v] == t) continue;
        const auto [it, isNew] = copies.try_emplace({v, {t.x, t.y, t.z, t.w}}, uint32_t(kept.size()));
        if (isNew) {
            kept.push_back(v);
            tangents.push_back(t);
        }
        part.indices[c] = it->second;
    }
    for (std::size_t v = 0; v < has.size(); ++v) {
        if (!has[v]) tangents[v] = vec4(TangentSpace::anySide(part.normals[v]), 1.0f);
    }
    if (kept.size() != part.positions.size()) selectVertices(part, kept);
    part.tangents = std::move(tangents);
}

} // namespace halflight
