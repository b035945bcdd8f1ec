// Solids: closed surfaces that face outward, found by connectivity alone. Inward-facing ones that are no rooms are
// flipped.
#include "bake/stages.h"

#include "halflight/base/disjoint_sets.h"
#include "halflight/base/parallel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <span>
#include <tuple>
#include <utility>

namespace halflight {
namespace {

/// An edge of a triangle between welded vertices, directed as the triangle winds.
struct DirectedEdge {
    uint32_t low = 0;
    uint32_t high = 0;
    uint32_t triangle = 0;
    bool forward = false; ///< from low to high
};

/// The corners of the listed triangles as indices of welded vertices: equal positions get equal indices.
std::vector<uvec3> weld(const BakeGeometry& geometry, std::span<const uint32_t> triangles)
{
    std::vector<uint32_t> corners(triangles.size() * 3); // 3 * index into `triangles` + corner
    std::iota(corners.begin(), corners.end(), 0u);
    const auto at = [&](uint32_t c) { return geometry.positions[geometry.triangles[triangles[c / 3]][int(c % 3)]]; };
    std::sort(corners.begin(), corners.end(), [&](uint32_t a, uint32_t b) {
        const vec3 p = at(a);
        const vec3 q = at(b);
        return std::tie(p.x, p.y, p.z, a) < std::tie(q.x, q.y, q.z, b);
    });
    std::vector<uvec3> welded(triangles.size());
    uint32_t vertex = 0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        if (i > 0 && at(corners[i]) != at(corners[i - 1])) ++vertex;
        welded[corners[i] / 3][int(corners[i] % 3)] = vertex;
    }
    return welded;
}

/// The edges of welded triangles, sorted so that edges with equal ends are adjacent.
std::vector<DirectedEdge> edgesOf(std::span<const uvec3> welded)
{
    std::vector<DirectedEdge> edges;
    edges.reserve(welded.size() * 3);
    for (std::size_t t = 0; t < welded.size(); ++t) {
        const uvec3 w = welded[t];
        if (w[0] == w[1] || w[1] == w[2] || w[2] == w[0]) continue; // degenerate
        for (int e = 0; e < 3; ++e) {
            const uint32_t a = w[e];
            const uint32_t b = w[(e + 1) % 3];
            edges.push_back({std::min(a, b), std::max(a, b), uint32_t(t), a < b});
        }
    }
    std::sort(edges.begin(), edges.end(), [](const DirectedEdge& a, const DirectedEdge& b) {
        return std::tie(a.low, a.high, a.triangle) < std::tie(b.low, b.high, b.triangle);
    });
    return edges;
}

/// Calls body(edges) for each group of edges with equal ends.
template<typename Body> void forEdges(std::span<const DirectedEdge> edges, const Body& body)
{
    for (std::size_t i = 0; i < edges.size();) {
        std::size_t j = i;
        while (j < edges.size() && edges[j].low == edges[i].low && edges[j].high == edges[i].high) ++j;
        body(edges.subspan(i, j - i));
        i = j;
    }
}

/// A closed surface: a connected component of triangles.
struct Component {
    std::vector<uint32_t> triangles;
    Bounds bounds;
};
struct Components {
    std::vector<Component> solids; ///< facing outward
    std::vector<Component> inward; ///< facing inward: rooms, cavities of solids, or inverted surfaces
    /// A component, closed or open: one of its triangles, and its bounds.
    struct Any {
        uint32_t triangle = 0;
        Bounds bounds;
    };
    std::vector<Any> all;
};

/// The connected components of the listed triangles.
Components componentsOf(const BakeGeometry& geometry, std::span<const uint32_t> triangles)
{
    const std::vector<DirectedEdge> edges = edgesOf(weld(geometry, triangles));

    // Components are connected across edges. A component is closed if each edge has as many triangles in one direction
    // as in the other.
    DisjointSets sets(triangles.size());
    std::vector<uint32_t> openTriangles;
    forEdges(edges, [&](std::span<const DirectedEdge> same) {
        int balance = 0;
        for (const DirectedEdge& edge : same) {
            balance += edge.forward ? 1 : -1;
            sets.join(same.front().triangle, edge.triangle);
        }
        if (balance != 0) openTriangles.push_back(same.front().triangle);
    });
    std::vector<uint8_t> open(triangles.size(), 0);
    for (const uint32_t t : openTriangles) open[sets.find(t)] = 1;

    // The sign of the enclosed volume is positive for outward-facing components.
    std::vector<double> volume(triangles.size(), 0.0);
    const vec3 reference = geometry.positions[geometry.triangles[triangles[0]].x];
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        const uvec3 v = geometry.triangles[triangles[t]];
        volume[sets.find(uint32_t(t))] +=
            double(glm::dot(geometry.positions[v.x] - reference,
                            glm::cross(geometry.positions[v.y] - reference, geometry.positions[v.z] - reference)));
    }
    Components components;
    std::vector<Component*> componentOf(triangles.size(), nullptr);
    std::vector<uint32_t> roots;
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        if (sets.find(uint32_t(t)) == t && !open[t] && volume[t] != 0.0) roots.push_back(uint32_t(t));
    }
    const auto outward = [&](uint32_t root) { return volume[root] > 0.0; };
    const auto count = std::size_t(std::count_if(roots.begin(), roots.end(), outward));
    components.solids.resize(count); // once: componentOf points into the list
    components.inward.resize(roots.size() - count);
    std::size_t nextSolid = 0;
    std::size_t nextInward = 0;
    for (const uint32_t root : roots)
        componentOf[root] = outward(root) ? &components.solids[nextSolid++] : &components.inward[nextInward++];
    std::vector<Bounds> bounds(triangles.size()); // by root
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        const uint32_t root = sets.find(uint32_t(t));
        bounds[root].extend(geometry.boundsOf(triangles[t]));
        if (componentOf[root]) componentOf[root]->triangles.push_back(triangles[t]);
    }
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        if (sets.find(uint32_t(t)) != t) continue;
        components.all.push_back({triangles[t], bounds[t]});
        if (componentOf[t]) componentOf[t]->bounds = bounds[t];
    }
    return components;
}

/// Winding number of a closed component around a point, the sum of its triangles' solid angles over 4 pi. It is 1
/// inside an outward-facing component, -1 inside an inward-facing one, 0 outside (Van Oosterom and Strackee 1983, "The
/// Solid Angle of a Plane Triangle", eq. 8).
double windingNumber(const BakeGeometry& geometry, const Component& component, vec3 point)
{
    double sum = 0.0;
    for (const uint32_t t : component.triangles) {
        const uvec3 v = geometry.triangles[t];
        const glm::dvec3 a(geometry.positions[v.x] - point);
        const glm::dvec3 b(geometry.positions[v.y] - point);
        const glm::dvec3 c(geometry.positions[v.z] - point);
        const double la = glm::length(a);
        const double lb = glm::length(b);
        const double lc = glm::length(c);
        sum += std::atan2(glm::dot(a, glm::cross(b, c)),
                          la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb);
    }
    return sum / (2.0 * double(kPi));
}

bool within(const Bounds& inner, const Bounds& outer)
{
    return glm::all(glm::lessThanEqual(outer.min, inner.min)) && glm::all(glm::greaterThanEqual(outer.max, inner.max));
}

/// A cavity is an inward-facing component within a solid. It counts as part of the solid, so that a ray from within the
/// cavity enters the solid before it leaves it. An inward-facing room within no solid is none: objects in the room
/// would lie inside it.
bool isCavity(const BakeGeometry& geometry, const Component& component, std::span<const Component> solids)
{
    const vec3 point = geometry.centroid(component.triangles.front());
    return std::any_of(solids.begin(), solids.end(), [&](const Component& solid) {
        return within(component.bounds, solid.bounds) && windingNumber(geometry, solid, point) > 0.5;
    });
}

/// Finds inverted components: inward-facing ones that are double-sided, not emissive, empty, and not the whole scene. A
/// room has objects, a light or a camera in it, or is the whole scene.
class InversionTest {
public:
    InversionTest(const Scene& scene, const BakeGeometry& geometry)
        : scene_(scene), geometry_(geometry), points_(lightAndViewPoints(scene))
    {
        for (const BakeGeometry::Part& part : geometry.parts) {
            Bounds& bounds = boundsOfPart_.emplace_back();
            for (uint32_t v = part.firstVertex; v < part.firstVertex + part.vertexCount; ++v)
                bounds.extend(geometry.positions[v]);
            bounds_.extend(bounds);
        }
    }

    /// Whether a component is double-sided, not emissive, and not the whole scene.
    [[nodiscard]] bool canBeInverted(const Component& component) const
    {
        return !within(bounds_, component.bounds) &&
               std::all_of(component.triangles.begin(), component.triangles.end(), [&](uint32_t t) {
                   const int material = geometry_.parts[geometry_.partOfTriangle[t]].material;
                   if (material < 0) return false;
                   const Material& m = scene_.materials[std::size_t(material)];
                   return m.doubleSided && m.emissiveNits == vec3(0.0f);
               });
    }
    /// Whether a component contains nothing as a whole: no component of `among` (sorted by their bounds' least x), no
    /// part without triangles in it, no point of lightAndViewPoints(). Objects that cross its surface do not count,
    /// such as plants in a pond.
    [[nodiscard]] bool isEmpty(const Component& component, std::span<const Components::Any> among) const
    {
        auto other = std::lower_bound(among.begin(), among.end(), component.bounds.min.x,
                                      [](const Components::Any& c, float x) { return c.bounds.min.x < x; });
        for (; other != among.end() && other->bounds.min.x <= component.bounds.max.x; ++other) {
            const bool own =
                std::binary_search(component.triangles.begin(), component.triangles.end(), other->triangle);
            if (!own && within(other->bounds, component.bounds) &&
                holds(component, geometry_.centroid(other->triangle)))
                return false;
        }
        for (uint32_t i = 0; i < boundsOfPart_.size(); ++i) {
            const BakeGeometry::Part& part = geometry_.parts[i];
            const bool inside = !boundsOfPart_[i].empty() && within(boundsOfPart_[i], component.bounds);
            if (inside && !hasTriangleOf(component, part) && holds(component, geometry_.positions[part.firstVertex]))
                return false;
        }
        return std::none_of(points_.begin(), points_.end(), [&](vec3 point) { return holds(component, point); });
    }

private:
    [[nodiscard]] bool holds(const Component& component, vec3 point) const
    {
        return within({point, point}, component.bounds) && windingNumber(geometry_, component, point) < -0.5;
    }
    static bool hasTriangleOf(const Component& component, const BakeGeometry::Part& part)
    {
        const auto next = std::lower_bound(component.triangles.begin(), component.triangles.end(), part.firstTriangle);
        return next != component.triangles.end() && *next < part.firstTriangle + part.triangleCount;
    }

    const Scene& scene_;
    const BakeGeometry& geometry_;
    std::vector<vec3> points_;
    std::vector<Bounds> boundsOfPart_;
    Bounds bounds_;
};

bool ofOneObject(const BakeGeometry& geometry, const Component& component)
{
    const auto objectOf = [&](uint32_t t) { return geometry.parts[geometry.partOfTriangle[t]].object; };
    return objectOf(component.triangles.front()) ==
           objectOf(component.triangles.back()); // triangles are sorted by object
}

/// Marks the solids among the listed triangles, and flips inverted components. `together`: the triangles are of several
/// objects, each of which has been tested by itself.
void markSolids(BakeGeometry& geometry, std::span<const uint32_t> triangles, const InversionTest& inversion,
                bool together)
{
    Components components = componentsOf(geometry, triangles);
    const auto mark = [&](const Component& component) {
        for (const uint32_t t : component.triangles) geometry.solid[t] = 1;
    };
    for (const Component& component : components.solids) mark(component);
    if (components.inward.empty()) return;
    std::sort(components.all.begin(), components.all.end(),
              [](const auto& a, const auto& b) { return a.bounds.min.x < b.bounds.min.x; });
    for (const Component& component : components.inward) {
        if (isCavity(geometry, component, components.solids)) {
            mark(component);
        } else if (inversion.canBeInverted(component) && !(together && ofOneObject(geometry, component)) &&
                   inversion.isEmpty(component, components.all)) {
            flipTriangles(geometry, component.triangles);
            mark(component);
        }
    }
}

} // namespace

std::vector<vec3> lightAndViewPoints(const Scene& scene)
{
    std::vector<vec3> points;
    for (const Light& light : scene.lights) {
        if (light.type != LightType::Directional) points.push_back(light.position());
    }
    for (const Camera& camera : scene.cameras) points.emplace_back(camera.worldFromCamera[3]);
    for (const Object& object : scene.objects) {
        if (!object.isStatic) points.emplace_back(object.worldFromObject[3]);
    }
    return points;
}

void flipTriangles(BakeGeometry& geometry, std::span<const uint32_t> triangles)
{
    for (const uint32_t t : triangles) {
        geometry.flipped[t] = 1;
        uvec3& v = geometry.triangles[t];
        std::swap(v.y, v.z);
        geometry.frames[t].normal = -geometry.frames[t].normal;
        for (int corner = 0; corner < 3; ++corner) {
            vec3& normal = geometry.normals[v[corner]];
            if (glm::dot(normal, geometry.geometricNormal(t)) < 0.0f) normal = -normal;
        }
    }
}

std::vector<std::vector<uint32_t>> facetPatches(const BakeGeometry& geometry, std::span<const uint32_t> triangles)
{
    constexpr float kSharp = 0.64f; // cosine of 50 degrees
    if (triangles.empty()) return {};
    DisjointSets sets(triangles.size());
    const std::vector<DirectedEdge> edges = edgesOf(weld(geometry, triangles));
    forEdges(edges, [&](std::span<const DirectedEdge> same) {
        if (same.size() != 2 || same[0].forward == same[1].forward) return;
        const vec3 normal = geometry.geometricNormal(triangles[same[0].triangle]);
        if (glm::dot(normal, geometry.geometricNormal(triangles[same[1].triangle])) < kSharp) return;
        sets.join(same[0].triangle, same[1].triangle);
    });
    std::vector<std::vector<uint32_t>> patches;
    std::vector<uint32_t> patchOf(triangles.size());
    for (uint32_t t = 0; t < triangles.size(); ++t) {
        const uint32_t root = sets.find(t);
        if (root == t) {
            patchOf[t] = uint32_t(patches.size());
            patches.emplace_back();
        }
        patches[patchOf[root]].push_back(triangles[t]);
    }
    return patches;
}

void findSolids(const Scene& scene, BakeGeometry& geometry)
{
    // Object by object first: objects that touch must not be connected.
    geometry.solid.assign(geometry.triangles.size(), 0);
    geometry.flipped.assign(geometry.triangles.size(), 0);
    const InversionTest inversion(scene, geometry);
    std::vector<std::vector<uint32_t>> objects;
    for (std::size_t i = 0; i < geometry.parts.size();) {
        std::vector<uint32_t>& list = objects.emplace_back();
        const int object = geometry.parts[i].object;
        for (; i < geometry.parts.size() && geometry.parts[i].object == object; ++i) {
            const BakeGeometry::Part& part = geometry.parts[i];
            for (uint32_t t = 0; t < part.triangleCount; ++t) list.push_back(part.firstTriangle + t);
        }
    }
    parallelFor(objects.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t o = begin; o < end; ++o) {
            if (!objects[o].empty()) markSolids(geometry, objects[o], inversion, false);
        }
    });

    // Then the remaining triangles of all objects together: buildings are often one closed surface cut into several
    // objects.
    constexpr std::size_t kMaxTogether = 4'000'000;
    std::vector<uint32_t> rest;
    for (uint32_t t = 0; t < geometry.triangles.size(); ++t) {
        if (!geometry.solid[t]) rest.push_back(t);
    }
    if (!rest.empty() && rest.size() <= kMaxTogether) markSolids(geometry, rest, inversion, true);
}

} // namespace halflight
