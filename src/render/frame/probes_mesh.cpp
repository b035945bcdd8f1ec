// Building the mesh: from probe positions to lattice points, tetrahedra, hull and starting cells. Then finding a point.
#include "render/frame/probes_mesh.h"

#include "halflight/base/finite.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>
#include <tuple>
#include <utility>

namespace halflight {
namespace {

using glm::dmat3;
using glm::dvec3;

/// An extent below this share of the largest one is none: probes meant to lie in a plane or on a line, in floats.
constexpr double kFlat = 1.0e-5;

/// Orthonormal axes along which points spread most, second most and least, and along how many of them they do.
struct Spread {
    int rank = 0;
    dmat3 axes{1.0};
};

Spread spreadOf(std::span<const dvec3> points)
{
    const auto farthest = [&](auto distance) {
        std::size_t best = 0;
        double bestDistance = -1.0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const double d = distance(points[i]);
            if (d > bestDistance) std::tie(best, bestDistance) = std::pair(i, d);
        }
        return std::pair(points[best], bestDistance);
    };
    Spread spread;
    const dvec3 a = farthest([&](dvec3 p) { return glm::distance(p, points[0]); }).first;
    const auto [b, length] = farthest([&](dvec3 p) { return glm::distance(p, a); });
    if (!(length > 0.0)) return spread;
    const dvec3 x = (b - a) / length;
    const auto offAxis = [&](dvec3 p) { return (p - a) - glm::dot(p - a, x) * x; };
    const auto [c, width] = farthest([&](dvec3 p) { return glm::length(offAxis(p)); });
    spread.rank = 1;
    dvec3 y = glm::cross(x, std::abs(x.y) < 0.9 ? dvec3(0, 1, 0) : dvec3(1, 0, 0));
    if (width > kFlat * length) {
        spread.rank = 2;
        y = offAxis(c);
    }
    y = glm::normalize(y - glm::dot(y, x) * x);
    const dvec3 z = glm::cross(x, y);
    const double height = farthest([&](dvec3 p) { return std::abs(glm::dot(p - a, z)); }).second;
    if (spread.rank == 2 && height > kFlat * length) spread.rank = 3;
    spread.axes = dmat3(x, y, z);
    return spread;
}

bool isGrid(const ProbeSet& set)
{
    const ivec3 size = set.size;
    if (glm::any(glm::lessThan(size, ivec3(1))) || glm::any(glm::greaterThan(size, ivec3(1 << kLatticeBits))) ||
        uint64_t(size.x) * uint64_t(size.y) * uint64_t(size.z) != set.probes.size() || !isFinite(set.origin))
        return false;
    for (int axis = 0; axis < 3; ++axis) {
        if (size[axis] > 1 && !(set.spacingMeters[axis] > 0.0f && std::isfinite(set.spacingMeters[axis]))) return false;
    }
    return true;
}

ivec3 gridPlace(const ProbeSet& set, uint32_t i)
{
    const auto x = uint32_t(set.size.x);
    const auto y = uint32_t(set.size.y);
    return {int(i % x), int(i / x % y), int(i / (x * y))};
}

/// For free lists, as if they were spread evenly over their bounds.
vec3 meanSpacing(const dvec3& size, std::size_t count)
{
    double product = 1.0;
    int axes = 0;
    for (int axis = 0; axis < 3; ++axis) {
        if (size[axis] > 0.0) product *= size[axis];
        axes += size[axis] > 0.0;
    }
    if (axes == 0) return vec3(kInfinity);
    const double perAxis = std::max(std::pow(double(count), 1.0 / axes) - 1.0, 1.0);
    const double spacing = std::pow(product, 1.0 / axes) / perAxis;
    vec3 result(kInfinity);
    for (int axis = 0; axis < 3; ++axis) {
        if (size[axis] > 0.0) result[axis] = float(spacing);
    }
    return result;
}

} // namespace

ProbeMesh::ProbeMesh(const BakedScene& baked) : sky_(skyProbe(baked.scene.sky))
{
    const ProbeSet& set = baked.probes;
    const bool grid = isGrid(set);
    for (uint32_t i = 0; i < set.probes.size(); ++i) {
        if (set.probes[i].valid && (grid || isFinite(set.probes[i].position))) sources_.push_back(i);
    }
    if (sources_.empty()) return;
    std::vector<ivec3> lattice;
    placeVertices(set, lattice);
    for (const uint32_t source : sources_) probes_.push_back(set.probes[source]);

    cells_ = tetrahedralize(lattice);
    assert(!cells_.empty());
    peelFlatCells();
    buildHull();
    buildStarts();
}

// Lattice points of the probes. A grid's are its own indices, exact; a free list's its positions rounded to a
// four-millionth of its extent, which is about what floats tell apart. Along an axis without extent every probe gets a
// copy one layer up. So there are tetrahedra in any case, while points in question stay in the lowest layer, which is a
// face of the hull: on it the mesh is the Delaunay triangulation of the plane, or on an edge of it the line's
// intervals.
void ProbeMesh::placeVertices(const ProbeSet& set, std::vector<ivec3>& lattice)
{
    const bool grid = isGrid(set);
    const std::size_t count = sources_.size();
    std::vector<dvec3> world(count);
    dvec3 low(kInfinity);
    dvec3 high(-kInfinity);
    for (std::size_t i = 0; i < count; ++i) {
        const uint32_t source = sources_[i];
        world[i] = grid ? dvec3(set.origin) + dvec3(set.spacingMeters) * dvec3(gridPlace(set, source))
                        : dvec3(set.probes[source].position);
        low = glm::min(low, world[i]);
        high = glm::max(high, world[i]);
    }
    const Spread spread = spreadOf(world);
    const double extent = std::max({high.x - low.x, high.y - low.y, high.z - low.z});
    int extended = 0;
    for (int axis = 0; axis < 3; ++axis) {
        flat_[axis] = !(high[axis] - low[axis] > (grid ? 0.0 : kFlat * extent));
        extended += !flat_[axis];
    }
    const bool axisAligned = extended == spread.rank;

    origin_ = low;
    dvec3 scale(1.0);
    int layer = 1;
    lattice.resize(count);
    if (grid && axisAligned) {
        ivec3 first(1 << kLatticeBits);
        for (std::size_t i = 0; i < count; ++i) {
            lattice[i] = gridPlace(set, sources_[i]);
            first = glm::min(first, lattice[i]);
        }
        for (ivec3& place : lattice) place -= first;
        for (int axis = 0; axis < 3; ++axis) {
            if (!flat_[axis]) scale[axis] = double(set.spacingMeters[axis]);
        }
    } else {
        if (!axisAligned) {
            frame_ = spread.axes;
            for (int axis = 0; axis < 3; ++axis) flat_[axis] = axis >= spread.rank;
            dvec3 corner(kInfinity);
            for (const dvec3& p : world) corner = glm::min(corner, (p - low) * frame_);
            origin_ = low + frame_ * corner;
        }
        dvec3 size(0.0);
        for (const dvec3& p : world) size = glm::max(size, (p - origin_) * frame_);
        const int steps = 1 << kLatticeBits;
        const double largest = std::max({size.x, size.y, size.z});
        if (spread.rank > 0) {
            stepMeters_ = largest / steps;
            scale = dvec3(stepMeters_);
            layer = std::max(1, int(steps / std::ceil(std::pow(double(count), 1.0 / spread.rank))));
        }
        for (std::size_t i = 0; i < count; ++i) {
            const dvec3 place = (world[i] - origin_) * frame_ / scale;
            for (int axis = 0; axis < 3; ++axis)
                lattice[i][axis] = flat_[axis] ? 0 : glm::clamp(int(std::lround(place[axis])), 0, steps);
        }
    }

    // The first of probes at one place.
    std::vector<uint32_t> order(count);
    std::iota(order.begin(), order.end(), 0u);
    const auto key = [&](uint32_t i) { return std::tuple(lattice[i].z, lattice[i].y, lattice[i].x); };
    std::sort(order.begin(), order.end(),
              [&](uint32_t a, uint32_t b) { return key(a) != key(b) ? key(a) < key(b) : a < b; });
    order.erase(std::unique(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return key(a) == key(b); }),
                order.end());
    std::sort(order.begin(), order.end());
    std::vector<ivec3> points;
    std::vector<uint32_t> sources;
    for (const uint32_t i : order) {
        points.push_back(lattice[i]);
        sources.push_back(sources_[i]);
    }
    sources_ = std::move(sources);
    probeOf_.resize(points.size());
    std::iota(probeOf_.begin(), probeOf_.end(), 0u);
    for (int axis = 0; axis < 3; ++axis) {
        if (!flat_[axis]) continue;
        const std::size_t below = points.size();
        for (std::size_t i = 0; i < below; ++i) {
            ivec3 above = points[i];
            above[axis] = layer;
            points.push_back(above);
            probeOf_.push_back(probeOf_[i]);
        }
    }
    lattice = std::move(points);
    for (const ivec3& place : lattice) vertices_.push_back(dvec3(place) * scale);

    if (grid) {
        for (int axis = 0; axis < 3; ++axis) {
            if (set.size[axis] > 1) spacing_[axis] = set.spacingMeters[axis];
        }
    } else {
        spacing_ = meanSpacing(high - low, sources_.size());
    }
}

// Floats round probes of a plane to a little beside it, and where that is a side of the hull it is covered with flat
// cells that join probes far from each other. They go, as long as every probe keeps a cell.
void ProbeMesh::peelFlatCells()
{
    if (stepMeters_ == 0.0) return;
    const auto isFlat = [&](const Tetrahedron& cell) {
        std::array<dvec3, 4> v;
        for (std::size_t i = 0; i < 4; ++i) v[i] = vertices_[cell.vertex[i]];
        double longest = 0.0;
        double area = 0.0;
        for (std::size_t i = 0; i < 4; ++i) {
            const dvec3& a = v[(i + 1) % 4];
            const dvec3& b = v[(i + 2) % 4];
            const dvec3& c = v[(i + 3) % 4];
            area = std::max(area, glm::length(glm::cross(b - a, c - a)));
            longest = std::max(longest, glm::distance(v[i], a));
            longest = std::max(longest, glm::distance(v[i], b));
        }
        const double volume = glm::dot(v[1] - v[0], glm::cross(v[2] - v[0], v[3] - v[0]));
        return volume < area * (kFlat * longest + 4.0 * stepMeters_);
    };
    std::vector<uint32_t> uses(vertices_.size(), 0);
    for (const Tetrahedron& cell : cells_) {
        for (const uint32_t v : cell.vertex) ++uses[v];
    }
    std::vector<uint32_t> queue;
    for (uint32_t i = 0; i < cells_.size(); ++i) {
        const auto& n = cells_[i].neighbor;
        if (std::find(n.begin(), n.end(), kOutside) != n.end()) queue.push_back(i);
    }
    std::vector<bool> gone(cells_.size(), false);
    for (std::size_t k = 0; k < queue.size(); ++k) {
        const uint32_t i = queue[k];
        const Tetrahedron& cell = cells_[i];
        if (gone[i] || !isFlat(cell)) continue;
        if (std::any_of(cell.vertex.begin(), cell.vertex.end(), [&](uint32_t v) { return uses[v] < 2; })) continue;
        gone[i] = true;
        for (const uint32_t v : cell.vertex) --uses[v];
        for (const uint32_t n : cell.neighbor) {
            if (n == kOutside) continue;
            std::replace(cells_[n].neighbor.begin(), cells_[n].neighbor.end(), i, kOutside);
            queue.push_back(n);
        }
    }
    std::vector<uint32_t> place(cells_.size(), kOutside);
    uint32_t kept = 0;
    for (std::size_t i = 0; i < cells_.size(); ++i) {
        if (gone[i]) continue;
        place[i] = kept;
        cells_[kept++] = cells_[i];
    }
    cells_.resize(kept);
    for (Tetrahedron& cell : cells_) {
        for (uint32_t& n : cell.neighbor) {
            if (n != kOutside) n = place[n];
        }
    }
}

void ProbeMesh::buildHull()
{
    std::vector<HullFaces::Face> faces;
    for (const Tetrahedron& cell : cells_) {
        for (std::size_t i = 0; i < 4; ++i) {
            if (cell.neighbor[i] != kOutside) continue;
            HullFaces::Face face{{cell.vertex[(i + 1) % 4], cell.vertex[(i + 2) % 4], cell.vertex[(i + 3) % 4]}};
            std::sort(face.vertex.begin(), face.vertex.end());
            faces.push_back(face);
        }
    }
    hull_.build(std::move(faces), vertices_);
}

// About one starting cell per probe, so that a walk is a few steps long.
void ProbeMesh::buildStarts()
{
    low_ = high_ = vertices_[0];
    for (const dvec3& v : vertices_) {
        low_ = glm::min(low_, v);
        high_ = glm::max(high_, v);
    }
    const dvec3 size = high_ - low_;
    const double edge = std::cbrt(size.x * size.y * size.z / double(vertices_.size()));
    for (int axis = 0; axis < 3; ++axis) startSize_[axis] = int(glm::clamp(std::ceil(size[axis] / edge), 1.0, 128.0));
    starts_.reserve(std::size_t(startSize_.x) * std::size_t(startSize_.y) * std::size_t(startSize_.z));
    uint32_t from = 0;
    for (int z = 0; z < startSize_.z; ++z) {
        for (int y = 0; y < startSize_.y; ++y) {
            for (int x = 0; x < startSize_.x; ++x) {
                from = walk(from, low_ + (dvec3(x, y, z) + 0.5) / dvec3(startSize_) * size).cell;
                starts_.push_back(from);
            }
        }
    }
}

std::size_t ProbeMesh::startCellOf(dvec3 point) const
{
    const dvec3 at = (point - low_) / (high_ - low_) * dvec3(startSize_);
    const ivec3 place(glm::clamp(at, dvec3(0.0), dvec3(startSize_ - 1)));
    return (std::size_t(place.z) * std::size_t(startSize_.y) + std::size_t(place.y)) * std::size_t(startSize_.x) +
           std::size_t(place.x);
}

/// Barycentric coordinates times six volumes.
std::array<double, 4> ProbeMesh::weightsIn(const Tetrahedron& cell, dvec3 point) const
{
    const dvec3 a = vertices_[cell.vertex[0]] - point;
    const dvec3 b = vertices_[cell.vertex[1]] - point;
    const dvec3 c = vertices_[cell.vertex[2]] - point;
    const dvec3 d = vertices_[cell.vertex[3]] - point;
    const dvec3 cd = glm::cross(c, d);
    const dvec3 ab = glm::cross(a, b);
    return {glm::dot(b, cd), -glm::dot(a, cd), glm::dot(ab, d), -glm::dot(ab, c)};
}

/// Towards the point, through the face that it is farthest behind. A step back, or very many, mean that the point is on
/// a face as far as doubles can tell.
ProbeMesh::Where ProbeMesh::walk(uint32_t start, dvec3 point) const
{
    Where where{start};
    uint32_t from = kOutside;
    for (int step = 0; step < 100000; ++step) {
        const Tetrahedron& cell = cells_[where.cell];
        where.weights = weightsIn(cell, point);
        std::size_t least = 0;
        double size = 0.0;
        for (std::size_t i = 0; i < 4; ++i) {
            if (where.weights[i] < where.weights[least]) least = i;
            size += std::abs(where.weights[i]);
        }
        const uint32_t next = cell.neighbor[least];
        if (!(where.weights[least] < -1.0e-14 * size)) break;
        if (next == kOutside) {
            where.outside = true;
            break;
        }
        if (next == from) break;
        from = std::exchange(where.cell, next);
    }
    return where;
}

ProbeWeights ProbeMesh::weights(vec3 position) const
{
    ProbeWeights result;
    if (empty()) return result;
    if (!isFinite(position)) position = vec3(origin_);
    dvec3 point = (dvec3(position) - origin_) * frame_; // transpose(frame) * v
    for (int axis = 0; axis < 3; ++axis) {
        if (flat_[axis]) point[axis] = 0.0;
    }

    std::array<std::pair<uint32_t, double>, 4> shares;
    const Where where = walk(starts_[startCellOf(point)], point);
    if (where.outside) {
        const HullFaces::Nearest nearest = hull_.nearest(point, vertices_);
        for (std::size_t i = 0; i < 3; ++i)
            shares[i] = {probeOf_[hull_.face(nearest.face).vertex[i]], nearest.weights[i]};
        shares[3] = {shares[0].first, 0.0};
    } else {
        for (std::size_t i = 0; i < 4; ++i)
            shares[i] = {probeOf_[cells_[where.cell].vertex[i]], std::max(where.weights[i], 0.0)};
    }

    // Copies of a probe count as one. In the order of probes, so that a sum does not depend on the cell's.
    std::sort(shares.begin(), shares.end());
    double total = 0.0;
    for (std::size_t i = 0; i < 4; ++i) {
        total += shares[i].second;
        if (i > 0 && shares[i].first == shares[i - 1].first) {
            shares[i].second += std::exchange(shares[i - 1].second, 0.0);
        }
    }
    for (std::size_t i = 0; i < 4; ++i) {
        result.probes[i] = shares[i].first;
        result.weights[i] = total > 0.0 ? float(shares[i].second / total) : i == 3 ? 1.0f : 0.0f;
    }
    return result;
}

} // namespace halflight
