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

/// The corners of the listed triangles as numbers of places: equal positions get equal numbers.
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
    uint32_t place = 0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        if (i > 0 && at(corners[i]) != at(corners[i - 1])) ++place;
        welded[corners[i] / 3][int(corners[i] % 3)] = place;
    }
    return welded;
}

/// The edges of welded triangles, those of the same two places side by side.
std::vector<DirectedEdge> edgesOf(std::span<const uvec3> welded)
{
    std::vector<DirectedEdge> edges;
    edges.reserve(welded.size() * 3);
    for (std::size_t t = 0; t < welded.size(); ++t) {
        const uvec3 w = welded[t];
        if (w[0] == w[1] || w[1] == w[2] || w[2] == w[0]) continue; // collapsed: encloses nothing
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

/// Calls body(edges) for those of each two places.
template<typename Body> void forEdges(std::span<const DirectedEdge> edges, const Body& body)
{
    for (std::size_t i = 0; i < edges.size();) {
        std::size_t j = i;
        while (j < edges.size() && edges[j].low == edges[i].low && edges[j].high == edges[i].high) ++j;
        body(edges.subspan(i, j - i));
        i = j;
    }
}

/// A closed surface.
struct Piece {
    std::vector<uint32_t> triangles;
    Bounds bounds;
};
struct Pieces {
    std::vector<Piece> solids; ///< facing outward
    std::vector<Piece> inward; ///< facing inward: rooms, or the cavities of hollow bodies
    /// What hangs together, closed or open: one of its triangles, and its bounds.
    struct Thing {
        uint32_t triangle = 0;
        Bounds bounds;
    };
    std::vector<Thing> things;
};

/// The closed pieces among the listed triangles.
Pieces closedPieces(const BakeGeometry& geometry, std::span<const uint32_t> triangles)
{
    const std::vector<DirectedEdge> edges = edgesOf(weld(geometry, triangles));

    // Pieces hang together across edges; a piece is open as soon as as many triangles do not pass one of its edges in
    // one direction as in the other.
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

    // Outward or inward: the sign of the enclosed volume.
    std::vector<double> volume(triangles.size(), 0.0);
    const vec3 reference = geometry.positions[geometry.triangles[triangles[0]].x];
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        const uvec3 v = geometry.triangles[triangles[t]];
        volume[sets.find(uint32_t(t))] +=
            double(glm::dot(geometry.positions[v.x] - reference,
                            glm::cross(geometry.positions[v.y] - reference, geometry.positions[v.z] - reference)));
    }
    Pieces pieces;
    std::vector<Piece*> pieceOf(triangles.size(), nullptr);
    std::vector<uint32_t> roots;
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        if (sets.find(uint32_t(t)) == t && !open[t] && volume[t] != 0.0) roots.push_back(uint32_t(t));
    }
    const auto outward = [&](uint32_t root) { return volume[root] > 0.0; };
    const auto count = std::size_t(std::count_if(roots.begin(), roots.end(), outward));
    pieces.solids.resize(count); // never again, so that pointers stay
    pieces.inward.resize(roots.size() - count);
    std::size_t nextSolid = 0;
    std::size_t nextInward = 0;
    for (const uint32_t root : roots)
        pieceOf[root] = outward(root) ? &pieces.solids[nextSolid++] : &pieces.inward[nextInward++];
    std::vector<Bounds> bounds(triangles.size()); // by root
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        const uint32_t root = sets.find(uint32_t(t));
        bounds[root].extend(geometry.boundsOf(triangles[t]));
        if (pieceOf[root]) pieceOf[root]->triangles.push_back(triangles[t]);
    }
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        if (sets.find(uint32_t(t)) != t) continue;
        pieces.things.push_back({triangles[t], bounds[t]});
        if (pieceOf[t]) pieceOf[t]->bounds = bounds[t];
    }
    return pieces;
}

/// How often a closed piece winds around a point, 1 inside and 0 outside: the solid angles of its triangles over 4 pi
/// (Van Oosterom and Strackee 1983, "The Solid Angle of a Plane Triangle", eq. 8).
double windingNumber(const BakeGeometry& geometry, const Piece& piece, vec3 point)
{
    double sum = 0.0;
    for (const uint32_t t : piece.triangles) {
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

/// The cavity of a hollow body is closed on its own and faces inward: it lies within a solid. Its surface is then the
/// solid's too, so that a ray from within the cavity enters the solid before it leaves it. (An inward-facing room that
/// lies in no solid is not one itself: what stands in it would not be solid any more.)
bool isCavity(const BakeGeometry& geometry, const Piece& piece, std::span<const Piece> solids)
{
    const vec3 point = geometry.centroid(piece.triangles.front());
    return std::any_of(solids.begin(), solids.end(), [&](const Piece& solid) {
        return within(piece.bounds, solid.bounds) && windingNumber(geometry, solid, point) > 0.5;
    });
}

/// Tells which closed pieces that face inward do so by mistake: those that are seen from both sides, dark and empty
/// inside, and not all there is. A room has something in it, or a light, or is the whole scene.
class InsideOut {
public:
    InsideOut(const Scene& scene, const BakeGeometry& geometry)
        : scene_(scene), geometry_(geometry), places_(lightsAndLookers(scene))
    {
        for (const BakeGeometry::Part& part : geometry.parts) {
            Bounds& bounds = boundsOfPart_.emplace_back();
            for (uint32_t v = part.firstVertex; v < part.firstVertex + part.vertexCount; ++v)
                bounds.extend(geometry.positions[v]);
            bounds_.extend(bounds);
        }
    }

    /// Whether a piece has two sides, does not glow, and is not the whole scene.
    [[nodiscard]] bool canBe(const Piece& piece) const
    {
        return !within(bounds_, piece.bounds) &&
               std::all_of(piece.triangles.begin(), piece.triangles.end(), [&](uint32_t t) {
                   const int material = geometry_.parts[geometry_.partOfTriangle[t]].material;
                   if (material < 0) return false;
                   const Material& m = scene_.materials[std::size_t(material)];
                   return m.doubleSided && m.emissiveNits == vec3(0.0f);
               });
    }
    /// Whether nothing is in a piece as a whole: none of the things that it was found among, in ascending order of
    /// their bounds' least x, no part that it has no triangle of, no light, nothing that looks or moves. What only
    /// reaches in does not count: plants grow in ponds.
    [[nodiscard]] bool isEmpty(const Piece& piece, std::span<const Pieces::Thing> among) const
    {
        auto thing = std::lower_bound(among.begin(), among.end(), piece.bounds.min.x,
                                      [](const Pieces::Thing& t, float x) { return t.bounds.min.x < x; });
        for (; thing != among.end() && thing->bounds.min.x <= piece.bounds.max.x; ++thing) {
            const bool own = std::binary_search(piece.triangles.begin(), piece.triangles.end(), thing->triangle);
            if (!own && within(thing->bounds, piece.bounds) && holds(piece, geometry_.centroid(thing->triangle)))
                return false;
        }
        for (uint32_t i = 0; i < boundsOfPart_.size(); ++i) {
            const BakeGeometry::Part& part = geometry_.parts[i];
            const bool inside = !boundsOfPart_[i].empty() && within(boundsOfPart_[i], piece.bounds);
            if (inside && !hasTriangleOf(piece, part) && holds(piece, geometry_.positions[part.firstVertex]))
                return false;
        }
        return std::none_of(places_.begin(), places_.end(), [&](vec3 place) { return holds(piece, place); });
    }

private:
    [[nodiscard]] bool holds(const Piece& piece, vec3 point) const
    {
        return within({point, point}, piece.bounds) && windingNumber(geometry_, piece, point) < -0.5;
    }
    static bool hasTriangleOf(const Piece& piece, const BakeGeometry::Part& part)
    {
        const auto next = std::lower_bound(piece.triangles.begin(), piece.triangles.end(), part.firstTriangle);
        return next != piece.triangles.end() && *next < part.firstTriangle + part.triangleCount;
    }

    const Scene& scene_;
    const BakeGeometry& geometry_;
    std::vector<vec3> places_; ///< of lights and lookers
    std::vector<Bounds> boundsOfPart_;
    Bounds bounds_;
};

bool ofOneObject(const BakeGeometry& geometry, const Piece& piece)
{
    const auto objectOf = [&](uint32_t t) { return geometry.parts[geometry.partOfTriangle[t]].object; };
    return objectOf(piece.triangles.front()) == objectOf(piece.triangles.back()); // objects' triangles are in order
}

/// Marks the solids among the listed triangles, and turns those around that are inside out. `together`: of several
/// objects, which have been looked at one by one.
void markPieces(BakeGeometry& geometry, std::span<const uint32_t> triangles, const InsideOut& insideOut, bool together)
{
    Pieces pieces = closedPieces(geometry, triangles);
    const auto mark = [&](const Piece& piece) {
        for (const uint32_t t : piece.triangles) geometry.solid[t] = 1;
    };
    for (const Piece& piece : pieces.solids) mark(piece);
    if (pieces.inward.empty()) return;
    std::sort(pieces.things.begin(), pieces.things.end(),
              [](const auto& a, const auto& b) { return a.bounds.min.x < b.bounds.min.x; });
    for (const Piece& piece : pieces.inward) {
        if (isCavity(geometry, piece, pieces.solids)) {
            mark(piece);
        } else if (insideOut.canBe(piece) && !(together && ofOneObject(geometry, piece)) &&
                   insideOut.isEmpty(piece, pieces.things)) {
            turnAround(geometry, piece.triangles);
            mark(piece);
        }
    }
}

} // namespace

std::vector<vec3> lightsAndLookers(const Scene& scene)
{
    std::vector<vec3> places;
    for (const Light& light : scene.lights) {
        if (light.type != LightType::Directional) places.push_back(light.position());
    }
    for (const Camera& camera : scene.cameras) places.emplace_back(camera.worldFromCamera[3]);
    for (const Object& object : scene.objects) {
        if (!object.isStatic) places.emplace_back(object.worldFromObject[3]);
    }
    return places;
}

void turnAround(BakeGeometry& geometry, std::span<const uint32_t> triangles)
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

std::vector<std::vector<uint32_t>> facingPatches(const BakeGeometry& geometry, std::span<const uint32_t> triangles)
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
    // Object by object first: things that stand on one another must not hang together where they touch.
    geometry.solid.assign(geometry.triangles.size(), 0);
    geometry.flipped.assign(geometry.triangles.size(), 0);
    const InsideOut insideOut(scene, geometry);
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
            if (!objects[o].empty()) markPieces(geometry, objects[o], insideOut, false);
        }
    });

    // Then what is left of all objects together: buildings are often one closed surface cut into several objects.
    constexpr std::size_t kMaxTogether = 4'000'000;
    std::vector<uint32_t> rest;
    for (uint32_t t = 0; t < geometry.triangles.size(); ++t) {
        if (!geometry.solid[t]) rest.push_back(t);
    }
    if (!rest.empty() && rest.size() <= kMaxTogether) markPieces(geometry, rest, insideOut, true);
}

} // namespace halflight
