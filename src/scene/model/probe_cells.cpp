// From probe positions to lattice points and tetrahedra.
#include "halflight/scene/probe_cells.h"

#include "halflight/base/finite.h"
#include "halflight/base/mathematics.h"

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
    const double perAxis = std::max(math::pow(double(count), 1.0 / axes) - 1.0, 1.0);
    const double spacing = math::pow(product, 1.0 / axes) / perAxis;
    vec3 result(kInfinity);
    for (int axis = 0; axis < 3; ++axis) {
        if (size[axis] > 0.0) result[axis] = float(spacing);
    }
    return result;
}

class CellBuilder {
public:
    explicit CellBuilder(const ProbeSet& set) : set_(set) {}
    ProbeCells build();

private:
    void placeVertices();
    void mergePlaces();
    void addLayers(int layer);
    bool takeCellsOfSet();
    void peelFlatCells();

    const ProbeSet& set_;
    ProbeCells out_;
    std::vector<uint32_t> sources_; ///< indices of the probes in use
    std::vector<ivec3> lattice_;
    double stepMeters_ = 0.0; ///< of a lattice that positions are rounded to; 0 where they lie on it
};

// Lattice points of the probes. A grid's are its own indices, exact. A free list's are its positions, rounded to a
// power of two that is about a four-millionth of its extent: those of a bake are exact. Along an axis without extent
// every probe gets a copy one layer up. So there are tetrahedra in any case, while points in question stay in the
// lowest layer, which is a face of the hull: on it the mesh is the Delaunay triangulation of the plane, or on an edge
// of it the line's intervals.
void CellBuilder::placeVertices()
{
    const bool grid = isGrid(set_);
    const std::size_t count = sources_.size();
    std::vector<dvec3> world(count);
    dvec3 low(kInfinity);
    dvec3 high(-kInfinity);
    for (std::size_t i = 0; i < count; ++i) {
        const uint32_t source = sources_[i];
        world[i] = grid ? dvec3(set_.origin) + dvec3(set_.spacingMeters) * dvec3(gridPlace(set_, source))
                        : dvec3(set_.probes[source].position);
        low = glm::min(low, world[i]);
        high = glm::max(high, world[i]);
    }
    const Spread spread = spreadOf(world);
    const double extent = std::max({high.x - low.x, high.y - low.y, high.z - low.z});
    int extended = 0;
    for (int axis = 0; axis < 3; ++axis) {
        out_.flat[axis] = !(high[axis] - low[axis] > (grid ? 0.0 : kFlat * extent));
        extended += !out_.flat[axis];
    }
    const bool axisAligned = extended == spread.rank;

    out_.origin = low;
    dvec3 scale(1.0);
    int layer = 1;
    lattice_.resize(count);
    if (grid && axisAligned) {
        ivec3 first(1 << kLatticeBits);
        for (std::size_t i = 0; i < count; ++i) {
            lattice_[i] = gridPlace(set_, sources_[i]);
            first = glm::min(first, lattice_[i]);
        }
        for (ivec3& place : lattice_) place -= first;
        for (int axis = 0; axis < 3; ++axis) {
            if (!out_.flat[axis]) scale[axis] = double(set_.spacingMeters[axis]);
        }
    } else {
        if (!axisAligned) {
            out_.frame = spread.axes;
            for (int axis = 0; axis < 3; ++axis) out_.flat[axis] = axis >= spread.rank;
            dvec3 corner(kInfinity);
            for (const dvec3& p : world) corner = glm::min(corner, (p - low) * out_.frame);
            out_.origin = low + out_.frame * corner;
        }
        dvec3 size(0.0);
        for (const dvec3& p : world) size = glm::max(size, (p - out_.origin) * out_.frame);
        const double largest = std::max({size.x, size.y, size.z});
        if (spread.rank > 0) {
            const double step = math::exp2(std::ceil(math::log2(largest)) - kLatticeBits);
            scale = dvec3(step);
            layer = std::max(1, int(largest / step / std::ceil(math::pow(double(count), 1.0 / spread.rank))));
        }
        for (std::size_t i = 0; i < count; ++i) {
            const dvec3 place = (world[i] - out_.origin) * out_.frame / scale;
            for (int axis = 0; axis < 3; ++axis) {
                lattice_[i][axis] = out_.flat[axis] ? 0 : std::max(int(std::lround(place[axis])), 0);
                if (double(lattice_[i][axis]) != place[axis]) stepMeters_ = scale.x;
            }
        }
    }

    mergePlaces();
    addLayers(layer);
    for (const ivec3& place : lattice_) out_.vertices.push_back(dvec3(place) * scale);

    if (grid) {
        for (int axis = 0; axis < 3; ++axis) {
            if (set_.size[axis] > 1) out_.spacingMeters[axis] = set_.spacingMeters[axis];
        }
    } else {
        out_.spacingMeters = meanSpacing(high - low, sources_.size());
    }
}

// The first of probes at one place.
void CellBuilder::mergePlaces()
{
    std::vector<uint32_t> order(lattice_.size());
    std::iota(order.begin(), order.end(), 0u);
    const auto key = [&](uint32_t i) { return std::tuple(lattice_[i].z, lattice_[i].y, lattice_[i].x); };
    std::sort(order.begin(), order.end(),
              [&](uint32_t a, uint32_t b) { return key(a) != key(b) ? key(a) < key(b) : a < b; });
    order.erase(std::unique(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return key(a) == key(b); }),
                order.end());
    std::sort(order.begin(), order.end());
    std::vector<ivec3> points;
    std::vector<uint32_t> sources;
    for (const uint32_t i : order) {
        points.push_back(lattice_[i]);
        sources.push_back(sources_[i]);
    }
    sources_ = std::move(sources);
    lattice_ = std::move(points);
}

// Along an axis without extent, a copy of each probe one layer up.
void CellBuilder::addLayers(int layer)
{
    out_.probeOf = sources_;
    for (int axis = 0; axis < 3; ++axis) {
        if (!out_.flat[axis]) continue;
        const std::size_t below = lattice_.size();
        for (std::size_t i = 0; i < below; ++i) {
            ivec3 above = lattice_[i];
            above[axis] = layer;
            lattice_.push_back(above);
            out_.probeOf.push_back(out_.probeOf[i]);
        }
    }
}

// Floats round probes of a plane to a little beside it, and where that is a side of the hull it is covered with flat
// cells that join probes far from each other. They go, as long as every probe keeps a cell.
void CellBuilder::peelFlatCells()
{
    if (stepMeters_ == 0.0) return;
    const auto isFlat = [&](const Tetrahedron& cell) {
        std::array<dvec3, 4> v;
        for (std::size_t i = 0; i < 4; ++i) v[i] = out_.vertices[cell.vertex[i]];
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
    std::vector<uint32_t> uses(out_.vertices.size(), 0);
    for (const Tetrahedron& cell : out_.cells) {
        for (const uint32_t v : cell.vertex) ++uses[v];
    }
    std::vector<uint32_t> queue;
    for (uint32_t i = 0; i < out_.cells.size(); ++i) {
        const auto& n = out_.cells[i].neighbor;
        if (std::find(n.begin(), n.end(), kOutside) != n.end()) queue.push_back(i);
    }
    std::vector<bool> gone(out_.cells.size(), false);
    for (std::size_t k = 0; k < queue.size(); ++k) {
        const uint32_t i = queue[k];
        const Tetrahedron& cell = out_.cells[i];
        if (gone[i] || !isFlat(cell)) continue;
        if (std::any_of(cell.vertex.begin(), cell.vertex.end(), [&](uint32_t v) { return uses[v] < 2; })) continue;
        gone[i] = true;
        for (const uint32_t v : cell.vertex) --uses[v];
        for (const uint32_t n : cell.neighbor) {
            if (n == kOutside) continue;
            std::replace(out_.cells[n].neighbor.begin(), out_.cells[n].neighbor.end(), i, kOutside);
            queue.push_back(n);
        }
    }
    std::vector<uint32_t> place(out_.cells.size(), kOutside);
    uint32_t kept = 0;
    for (std::size_t i = 0; i < out_.cells.size(); ++i) {
        if (gone[i]) continue;
        place[i] = kept;
        out_.cells[kept++] = out_.cells[i];
    }
    out_.cells.resize(kept);
    for (Tetrahedron& cell : out_.cells) {
        for (uint32_t& n : cell.neighbor) {
            if (n != kOutside) n = place[n];
        }
    }
}

// Those that a file brought, where they fit: of probes in use, and none turned inside out by an edit of positions.
bool CellBuilder::takeCellsOfSet()
{
    if (set_.tetrahedra.empty() || glm::any(out_.flat)) return false;
    std::vector<uint32_t> vertexOf(set_.probes.size(), kOutside);
    for (uint32_t v = 0; v < sources_.size(); ++v) vertexOf[sources_[v]] = v;
    std::vector<Tetrahedron> cells = set_.tetrahedra;
    for (Tetrahedron& cell : cells) {
        for (uint32_t& vertex : cell.vertex) {
            vertex = vertex < vertexOf.size() ? vertexOf[vertex] : kOutside;
            if (vertex == kOutside) return false;
        }
        const auto& v = out_.vertices;
        const dvec3 a = v[cell.vertex[0]];
        if (!(glm::dot(v[cell.vertex[1]] - a, glm::cross(v[cell.vertex[2]] - a, v[cell.vertex[3]] - a)) > 0.0))
            return false;
    }
    out_.cells = std::move(cells);
    return true;
}

ProbeCells CellBuilder::build()
{
    const bool grid = isGrid(set_);
    for (uint32_t i = 0; i < set_.probes.size(); ++i) {
        if (set_.probes[i].valid && (grid || isFinite(set_.probes[i].position))) sources_.push_back(i);
    }
    if (sources_.empty()) return std::move(out_);
    placeVertices();
    out_.probeCount = sources_.size();
    if (takeCellsOfSet()) return std::move(out_);
    out_.cells = tetrahedralize(lattice_);
    assert(!out_.cells.empty());
    peelFlatCells();
    return std::move(out_);
}

} // namespace

ProbeCells probeCells(const ProbeSet& set)
{
    return CellBuilder(set).build();
}

namespace {

// Vertices in ascending order, but for the last two where that would turn the tetrahedron inside out.
void turnForward(Tetrahedron& cell)
{
    const auto exchange = [&](std::size_t a, std::size_t b) {
        std::swap(cell.vertex[a], cell.vertex[b]);
        std::swap(cell.neighbor[a], cell.neighbor[b]);
    };
    bool isTurned = false;
    for (std::size_t end = 3; end > 0; --end) {
        for (std::size_t i = 0; i < end; ++i) {
            if (cell.vertex[i] < cell.vertex[i + 1]) continue;
            exchange(i, i + 1);
            isTurned = !isTurned;
        }
    }
    if (isTurned) exchange(2, 3);
}

} // namespace

// In the order of their first probes, each with its first probe first, so that the lists compress well.
std::vector<Tetrahedron> fileTetrahedra(const ProbeCells& cells)
{
    if (glm::any(cells.flat)) return {};
    std::vector<Tetrahedron> list = cells.cells;
    for (Tetrahedron& cell : list) {
        for (uint32_t& vertex : cell.vertex) vertex = cells.probeOf[vertex];
        turnForward(cell);
    }
    const auto key = [&](uint32_t i) {
        std::array<uint32_t, 4> vertices = list[i].vertex;
        std::sort(vertices.begin(), vertices.end());
        return vertices;
    };
    std::vector<uint32_t> order(list.size());
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return key(a) < key(b); });
    std::vector<uint32_t> place(list.size());
    for (uint32_t i = 0; i < order.size(); ++i) place[order[i]] = i;
    std::vector<Tetrahedron> sorted;
    for (const uint32_t i : order) {
        Tetrahedron& cell = sorted.emplace_back(list[i]);
        for (uint32_t& neighbor : cell.neighbor) {
            if (neighbor != kOutside) neighbor = place[neighbor];
        }
    }
    return sorted;
}

} // namespace halflight
