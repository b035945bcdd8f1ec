#include "unwrap/charts/chart.h"

#include "unwrap/charts/outline.h"
#include "unwrap/surface/overlap.h"

#include "halflight/base/disjoint_sets.h"
#include "halflight/base/memory.h"

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <queue>

namespace halflight::charts {
namespace {

/// Charts whose normals all stay this close to their mean are projected: the stretch is below 3 %.
constexpr double kProjectionCosine = 0.97;
constexpr int kRelaxations = 4;
/// Vertices of a chart up to which its matrix is factored; beyond, what is known of it in the large has to do, and the
/// small is put right in so many rounds of so many steps.
constexpr std::size_t kMostFactored = 100000;
constexpr int kRelaxationsOfLarge = 2;
constexpr int kSteps = 16;

/// Working copy of the chart: corners joined into vertices over the chart's own inner edges, so that sheets which only
/// touch in a point stay apart.
struct Piece {
    const Surface& surface;
    std::vector<uint32_t> triangles;
    std::vector<uint32_t> corners;
    std::vector<dvec3> positions;
    std::vector<char> onBorder; ///< by vertex
    dvec3 meanNormal{0.0};
    double area = 0.0;
    double perimeter = 0.0;
    double leastCosine = 1.0; ///< between a normal and the mean normal
    uint32_t leastTriangle = 0;

    Piece(const Surface& s, std::vector<uint32_t> t) : surface(s), triangles(std::move(t))
    {
        joinCorners();
        for (const uint32_t triangle : triangles) {
            meanNormal += surface.areas[triangle] * surface.normals[triangle];
            area += surface.areas[triangle];
        }
        const double length = glm::length(meanNormal);
        meanNormal = length > 1e-9 * area ? meanNormal / length : surface.normals[triangles[0]];
        for (const uint32_t triangle : triangles) {
            const double cosine = glm::dot(meanNormal, surface.normals[triangle]);
            if (cosine < leastCosine) {
                leastCosine = cosine;
                leastTriangle = triangle;
            }
        }
    }

    [[nodiscard]] uint32_t localIndex(uint32_t triangle) const
    {
        const auto found = std::lower_bound(triangles.begin(), triangles.end(), triangle);
        return found != triangles.end() && *found == triangle ? uint32_t(found - triangles.begin()) : kNone;
    }

private:
    void joinCorners()
    {
        DisjointSets joined(3 * triangles.size()); // corners at one place
        std::vector<char> borderCorner(joined.size(), 0);
        for (uint32_t i = 0; i < triangles.size(); ++i) {
            for (uint32_t k = 0; k < 3; ++k) {
                const uint32_t half = surface.neighbors[3 * triangles[i] + k];
                const uint32_t j = half == kNone ? kNone : localIndex(half / 3);
                if (j == kNone) {
                    borderCorner[3 * i + k] = borderCorner[3 * i + (k + 1) % 3] = 1;
                    perimeter += glm::distance(surface.corner(triangles[i], int(k)),
                                               surface.corner(triangles[i], int((k + 1) % 3)));
                } else if (i < j) {
                    joined.join(3 * i + k, 3 * j + (half % 3 + 1) % 3);
                    joined.join(3 * i + (k + 1) % 3, 3 * j + half % 3);
                }
            }
        }
        corners.assign(joined.size(), kNone);
        for (uint32_t c = 0; c < joined.size(); ++c) {
            const uint32_t root = joined.find(c);
            if (corners[root] == kNone) {
                corners[root] = uint32_t(positions.size());
                positions.push_back(surface.corner(triangles[root / 3], int(root % 3)));
                onBorder.push_back(0);
            }
            corners[c] = corners[root];
            if (borderCorner[c]) onBorder[corners[c]] = 1;
        }
    }
};

struct Basis {
    dvec3 x, y;
};

/// Two unit vectors that make a right-handed frame with `n` (Duff et al. 2017, "Building an Orthonormal Basis,
/// Revisited").
Basis basisOf(dvec3 n)
{
    const double sign = std::copysign(1.0, n.z);
    const double a = -1.0 / (sign + n.z), b = n.x * n.y * a;
    return {{1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}};
}

std::vector<dvec2> project(const Piece& piece)
{
    const Basis basis = basisOf(piece.meanNormal);
    const dvec3 origin = piece.positions[0];
    std::vector<dvec2> uv(piece.positions.size());
    for (std::size_t v = 0; v < uv.size(); ++v) {
        const dvec3 p = piece.positions[v] - origin;
        uv[v] = {glm::dot(p, basis.x), glm::dot(p, basis.y)};
    }
    return uv;
}

/// Turns `v` by the smallest rotation that takes the unit vector `from` to `to`.
dvec3 turned(dvec3 v, dvec3 from, dvec3 to)
{
    const double cosine = glm::dot(from, to);
    if (cosine < -0.999999) return v - 2.0 * glm::dot(v, to) * to;
    const dvec3 axis = glm::cross(from, to);
    return cosine * v + glm::cross(axis, v) + axis * (glm::dot(axis, v) / (1.0 + cosine));
}

/// The mean of what is said of a vertex's corners.
std::vector<dvec2> startingPoint(const Piece& piece, std::span<const dvec2> ofCorner)
{
    std::vector<dvec2> uv(piece.positions.size(), dvec2(0.0));
    std::vector<double> corners(uv.size(), 0.0);
    for (std::size_t c = 0; c < piece.corners.size(); ++c) {
        uv[piece.corners[c]] += ofCorner[c];
        corners[piece.corners[c]] += 1.0;
    }
    for (std::size_t v = 0; v < uv.size(); ++v) uv[v] /= corners[v];
    return uv;
}

/// As-rigid-as-possible flattening: Liu, Zhang, Xu, Gotsman and Gortler 2008, "A Local/Global Approach to Mesh
/// Parameterization". Each triangle starts in the frame that the smallest rotation of its normal onto the mean normal
/// gives it, so that a piece of a cylinder or cone lies flat after the first global step; or, with a guess, in the one
/// that fits it best.
std::vector<dvec2> relax(const Piece& piece, std::span<const dvec2> guess)
{
    const std::size_t triangleCount = piece.triangles.size(), vertexCount = piece.positions.size();
    const Basis basis = basisOf(piece.meanNormal);
    // Edge k of a triangle, flattened, and its weight: the cotangent of the opposite angle, kept positive.
    std::vector<dvec2> edges(3 * triangleCount);
    std::vector<double> weights(3 * triangleCount);
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(9 * triangleCount);
    const auto unknown = [](uint32_t vertex) { return int(vertex) - 1; }; // vertex 0 stays at the origin
    for (std::size_t t = 0; t < triangleCount; ++t) {
        const dvec3 normal = piece.surface.normals[piece.triangles[t]];
        const double doubleArea = 2.0 * piece.surface.areas[piece.triangles[t]];
        for (std::size_t k = 0; k < 3; ++k) {
            const uint32_t a = piece.corners[3 * t + k], b = piece.corners[3 * t + (k + 1) % 3];
            const dvec3 pa = piece.positions[a], pb = piece.positions[b];
            const dvec3 pc = piece.positions[piece.corners[3 * t + (k + 2) % 3]];
            const dvec3 edge = turned(pb - pa, normal, piece.meanNormal);
            edges[3 * t + k] = {glm::dot(edge, basis.x), glm::dot(edge, basis.y)};
            const double weight = std::clamp(glm::dot(pa - pc, pb - pc) / doubleArea, 0.02, 50.0);
            weights[3 * t + k] = weight;
            const int i = unknown(a), j = unknown(b);
            if (i >= 0) entries.emplace_back(i, i, weight);
            if (j >= 0) entries.emplace_back(j, j, weight);
            if (i >= 0 && j >= 0) {
                entries.emplace_back(i, j, -weight);
                entries.emplace_back(j, i, -weight);
            }
        }
    }
    const auto n = Eigen::Index(vertexCount) - 1;
    Eigen::SparseMatrix<double> laplacian(n, n);
    laplacian.setFromTriplets(entries.begin(), entries.end());
    release(entries);
    // Factors grow faster than charts do.
    const bool direct = vertexCount <= kMostFactored || guess.empty();
    Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver;
    Eigen::ConjugateGradient<Eigen::SparseMatrix<double>, Eigen::Lower | Eigen::Upper> stepper;
    if (direct) {
        solver.compute(laplacian);
        if (solver.info() != Eigen::Success) return project(piece);
    } else {
        stepper.setMaxIterations(kSteps);
        stepper.setTolerance(1e-6);
        stepper.compute(laplacian);
    }

    std::vector<dvec2> uv(vertexCount, dvec2(0.0)), rotation(triangleCount, dvec2(1.0, 0.0));
    const auto fitRotations = [&] {
        double change = 0.0;
        for (std::size_t t = 0; t < triangleCount; ++t) {
            dvec2 fit(0.0);
            for (std::size_t k = 0; k < 3; ++k) {
                const dvec2 e = edges[3 * t + k];
                const dvec2 u = uv[piece.corners[3 * t + (k + 1) % 3]] - uv[piece.corners[3 * t + k]];
                fit += weights[3 * t + k] * dvec2(glm::dot(e, u), e.x * u.y - e.y * u.x);
            }
            const double length = glm::length(fit);
            if (!(length > 0.0)) continue;
            change = std::max(change, glm::length(fit / length - rotation[t]));
            rotation[t] = fit / length;
        }
        return change;
    };
    Eigen::MatrixX2d right(n, 2), solution = Eigen::MatrixX2d::Zero(n, 2);
    if (!guess.empty()) {
        uv = startingPoint(piece, guess);
        for (std::size_t v = 1; v < vertexCount; ++v)
            solution.row(Eigen::Index(v) - 1) = Eigen::RowVector2d(uv[v].x - uv[0].x, uv[v].y - uv[0].y);
        fitRotations();
    }
    for (int iteration = 0; iteration <= (direct ? kRelaxations : kRelaxationsOfLarge); ++iteration) {
        right.setZero();
        for (std::size_t t = 0; t < triangleCount; ++t) {
            const dvec2 r = rotation[t];
            for (std::size_t k = 0; k < 3; ++k) {
                const dvec2 e = edges[3 * t + k];
                const dvec2 wanted = weights[3 * t + k] * dvec2(r.x * e.x - r.y * e.y, r.y * e.x + r.x * e.y);
                const int a = unknown(piece.corners[3 * t + k]), b = unknown(piece.corners[3 * t + (k + 1) % 3]);
                if (b >= 0) right.row(b) += Eigen::RowVector2d(wanted.x, wanted.y);
                if (a >= 0) right.row(a) -= Eigen::RowVector2d(wanted.x, wanted.y);
            }
        }
        if (direct)
            solution = solver.solve(right);
        else
            solution = stepper.solveWithGuess(right, Eigen::MatrixX2d(solution));
        uv[0] = dvec2(0.0);
        for (std::size_t v = 1; v < vertexCount; ++v) {
            uv[v] = {solution(Eigen::Index(v) - 1, 0), solution(Eigen::Index(v) - 1, 1)};
        }
        const double change = fitRotations();
        if (change < 1e-3) break;
    }
    return uv;
}

double doubleAreaOf(const Piece& piece, const std::vector<dvec2>& uv, std::size_t t)
{
    const dvec2 a = uv[piece.corners[3 * t]], b = uv[piece.corners[3 * t + 1]], c = uv[piece.corners[3 * t + 2]];
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/// The triangle that folds worst, or kNone. Thin triangles count as folded when they lose nearly all their area.
uint32_t findFold(const Piece& piece, const std::vector<dvec2>& uv)
{
    uint32_t worst = kNone;
    double worstShare = 0.02;
    for (std::size_t t = 0; t < piece.triangles.size(); ++t) {
        const double share = 0.5 * doubleAreaOf(piece, uv, t) / piece.surface.areas[piece.triangles[t]];
        if (share < worstShare || !std::isfinite(share)) {
            worstShare = std::isfinite(share) ? share : -1e300;
            worst = uint32_t(t);
        }
    }
    if (worst != kNone) return worst;
    // Around an inner vertex the triangles must turn once, not twice: as many corners as turns span the +x direction.
    std::vector<uint8_t> turns(piece.positions.size(), 0);
    for (std::size_t c = 0; c < piece.corners.size(); ++c) {
        const uint32_t vertex = piece.corners[c];
        if (piece.onBorder[vertex]) continue;
        const std::size_t t = c / 3;
        const dvec2 a = uv[piece.corners[3 * t + (c + 1) % 3]] - uv[vertex];
        const dvec2 b = uv[piece.corners[3 * t + (c + 2) % 3]] - uv[vertex];
        if (a.y < 0.0 && b.y >= 0.0 && ++turns[vertex] > 1) return uint32_t(t);
    }
    return kNone;
}

/// Lets vertices where triangles fold sink to the middle of their neighbours. What is marked once goes on sinking, so
/// that the patch which is free to move grows until nothing in it folds (Tutte 1963: at the least it lies flat once its
/// outline is convex). Borders stay.
void unfold(const Piece& piece, std::vector<dvec2>& uv)
{
    constexpr int kMostSteps = 30;
    constexpr double kFoldedShare = 0.05;
    const std::size_t count = piece.triangles.size();
    std::vector<char> loose(uv.size(), 0);
    std::vector<uint32_t> patch; // triangles at loose vertices
    std::vector<dvec3> sums(uv.size());
    for (int step = 0; step < kMostSteps; ++step) {
        bool folded = false;
        for (std::size_t t = 0; t < count; ++t) {
            const double share = 0.5 * doubleAreaOf(piece, uv, t) / piece.surface.areas[piece.triangles[t]];
            if (share > kFoldedShare) continue;
            if (!std::isfinite(share)) return;
            folded = true;
            for (std::size_t k = 0; k < 3; ++k) loose[piece.corners[3 * t + k]] = 1;
        }
        if (!folded) return;
        patch.clear();
        for (uint32_t t = 0; t < count; ++t) {
            const uint32_t* corner = piece.corners.data() + 3 * t;
            if (loose[corner[0]] || loose[corner[1]] || loose[corner[2]]) patch.push_back(t);
        }
        if (20 * patch.size() > count + 1000) return; // this is no small fault
        constexpr int kSinks = 6;
        for (int sink = 0; sink < kSinks; ++sink) {
            for (const uint32_t t : patch) {
                for (std::size_t k = 0; k < 3; ++k) sums[piece.corners[3 * t + k]] = dvec3(0.0);
            }
            for (const uint32_t t : patch) {
                for (std::size_t k = 0; k < 3; ++k) {
                    const dvec2 both = uv[piece.corners[3 * t + (k + 1) % 3]] + uv[piece.corners[3 * t + (k + 2) % 3]];
                    sums[piece.corners[3 * t + k]] += dvec3(both, 2.0);
                }
            }
            for (const uint32_t t : patch) {
                for (std::size_t k = 0; k < 3; ++k) {
                    const uint32_t vertex = piece.corners[3 * t + k];
                    if (loose[vertex] && !piece.onBorder[vertex]) uv[vertex] = dvec2(sums[vertex]) / sums[vertex].z;
                }
            }
        }
    }
}

/// A pair of triangles that overlap. Where nothing folds, a flattening overlaps itself only if its border does (the
/// number of sheets over a point is 0 far away and changes by one across a border), so only triangles at the border
/// are tested.
std::optional<std::pair<uint32_t, uint32_t>> findSelfOverlap(const Piece& piece, const std::vector<dvec2>& uv)
{
    std::vector<FlatTriangle> flat;
    std::vector<uint32_t> index;
    dvec2 least(1e300), most(-1e300);
    for (uint32_t t = 0; t < piece.triangles.size(); ++t) {
        bool border = false;
        FlatTriangle triangle;
        for (std::size_t k = 0; k < 3; ++k) {
            const uint32_t vertex = piece.corners[3 * t + k];
            border |= piece.onBorder[vertex] != 0;
            triangle.corners[k] = uv[vertex];
            least = glm::min(least, uv[vertex]);
            most = glm::max(most, uv[vertex]);
        }
        if (!border) continue;
        flat.push_back(triangle);
        index.push_back(t);
    }
    const auto found = findOverlap(flat, 1e-6 * glm::length(most - least));
    if (!found) return std::nullopt;
    return std::pair{index[found->first], index[found->second]};
}

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

/// Two triangles far apart in direction and place, for splitting.
std::pair<uint32_t, uint32_t> farApart(const Piece& piece, uint32_t from)
{
    const auto centroid = [&](uint32_t t) {
        return (piece.surface.corner(t, 0) + piece.surface.corner(t, 1) + piece.surface.corner(t, 2)) / 3.0;
    };
    const auto farthest = [&](uint32_t start) {
        uint32_t best = kNone;
        double bestDistance = -1.0;
        for (const uint32_t t : piece.triangles) {
            if (t == start) continue;
            const double bent = 1.0 - glm::dot(piece.surface.normals[t], piece.surface.normals[start]);
            const double distance = glm::distance(centroid(t), centroid(start)) / std::sqrt(piece.area) + 2.0 * bent;
            if (distance > bestDistance) {
                bestDistance = distance;
                best = t;
            }
        }
        return best;
    };
    return {from, farthest(from)};
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
        if (fold != kNone) {
            const auto [a, b] = farApart(piece, piece.triangles[fold]);
            return fail(a, b);
        }
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

std::array<std::vector<uint32_t>, 2> splitTriangles(const Surface& surface, const std::vector<uint32_t>& triangles,
                                                    uint32_t seedA, uint32_t seedB)
{
    const auto indexOf = [&](uint32_t t) {
        const auto found = std::lower_bound(triangles.begin(), triangles.end(), t);
        return found != triangles.end() && *found == t ? uint32_t(found - triangles.begin()) : kNone;
    };
    const auto centroid = [&](uint32_t t) {
        return (surface.corner(t, 0) + surface.corner(t, 1) + surface.corner(t, 2)) / 3.0;
    };
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
        uint8_t& mine = side[indexOf(front.triangle)];
        if (mine != 2) continue;
        mine = uint8_t(front.side);
        for (uint32_t k = 0; k < 3; ++k) {
            const uint32_t half = surface.neighbors[3 * front.triangle + k];
            if (half == kNone) continue;
            const uint32_t other = half / 3, index = indexOf(other);
            if (index == kNone || side[index] != 2) continue;
            const double bend = 1.0 - glm::dot(surface.normals[front.triangle], surface.normals[other]);
            const double step = glm::distance(centroid(front.triangle), centroid(other)) + size * bend;
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
    const auto indexOf = [&](uint32_t t) {
        const auto found = std::lower_bound(triangles.begin(), triangles.end(), t);
        return found != triangles.end() && *found == t ? std::size_t(found - triangles.begin()) : triangles.size();
    };
    std::vector<std::vector<uint32_t>> pieces;
    for (std::size_t start = 0; start < triangles.size(); ++start) {
        if (seen[start]) continue;
        std::vector<uint32_t>& piece = pieces.emplace_back();
        piece.push_back(triangles[start]);
        seen[start] = 1;
        for (std::size_t i = 0; i < piece.size(); ++i) {
            for (uint32_t k = 0; k < 3; ++k) {
                const uint32_t half = surface.neighbors[3 * piece[i] + k];
                const std::size_t index = half == kNone ? triangles.size() : indexOf(half / 3);
                if (index == triangles.size() || seen[index]) continue;
                seen[index] = 1;
                piece.push_back(half / 3);
            }
        }
        std::sort(piece.begin(), piece.end());
    }
    return pieces;
}

} // namespace halflight::charts
