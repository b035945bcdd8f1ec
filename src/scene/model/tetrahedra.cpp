// Incremental Delaunay tetrahedralization (Bowyer 1981, "Computing Dirichlet Tessellations"; Watson 1981, "Computing
// the n-dimensional Delaunay Tessellation"). Probes mostly lie on regular grids, where every sphere test is a tie and
// the hull is full of coplanar points: floating point gives holes, or flat cells, there. So all predicates are exact
// integers, and ties fall by a symbolic perturbation of the lifted heights (Devillers and Teillaud 2011, "Perturbations
// for Delaunay and Weighted Delaunay 3D Triangulations"), under which no four points of a plane ever become a cell.
#include "halflight/scene/tetrahedra.h"

#include "scene/model/wide.h"

#include <algorithm>
#include <cassert>
#include <tuple>
#include <utility>

namespace halflight {
namespace {

// Volumes below 2^71, squared distances below 2^46, and the sum of four of their products below 2^119: all fit into
// Wide.
using Vector = glm::i64vec3;

constexpr uint32_t kInfinite = 0xffffffffu; ///< the vertex beyond the hull: hull faces belong to cells with it

Vector cross(const Vector& u, const Vector& v)
{
    return {u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x};
}

/// Six times the signed volume.
Wide volume(const Vector& a, const Vector& b, const Vector& c, const Vector& d)
{
    const Vector u = b - a;
    const Vector n = cross(c - a, d - a);
    return Wide(u.x) * n.x + Wide(u.y) * n.y + Wide(u.z) * n.z;
}

/// Bits of `x` with two zeros between each.
uint64_t spread(uint64_t x)
{
    x = (x | x << 32) & 0x1f00000000ffffull;
    x = (x | x << 16) & 0x1f0000ff0000ffull;
    x = (x | x << 8) & 0x100f00f00f00f00full;
    x = (x | x << 4) & 0x10c30c30c30c30c3ull;
    return (x | x << 2) & 0x1249249249249249ull;
}

/// Biased randomized insertion order (Amenta, Choi and Rote 2003, "Incremental Constructions con BRIO"): rounds of
/// random points, each round twice the one before and in itself along a space-filling curve.
std::vector<uint32_t> insertionOrder(std::span<const ivec3> points)
{
    struct Key {
        int round;
        uint64_t morton;
        uint32_t point;
    };
    std::vector<Key> keys(points.size());
    for (uint32_t i = 0; i < points.size(); ++i) {
        uint64_t hash = (uint64_t(i) + 1) * 0x9e3779b97f4a7c15ull; // splitmix64's finalizer
        hash = (hash ^ hash >> 30) * 0xbf58476d1ce4e5b9ull;
        hash = (hash ^ hash >> 27) * 0x94d049bb133111ebull;
        hash ^= hash >> 31;
        int round = 0;
        for (; round < 32 && (hash & 1) != 0; hash >>= 1) ++round;
        const ivec3 p = points[i];
        const int drop = kLatticeBits - 20;
        keys[i] = {
            -round,
            spread(uint64_t(p.x >> drop)) | spread(uint64_t(p.y >> drop)) << 1 | spread(uint64_t(p.z >> drop)) << 2, i};
    }
    std::sort(keys.begin(), keys.end(), [](const Key& a, const Key& b) {
        return std::tie(a.round, a.morton, a.point) < std::tie(b.round, b.morton, b.point);
    });
    std::vector<uint32_t> order(points.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = keys[i].point;
    return order;
}

class Builder {
public:
    explicit Builder(std::span<const ivec3> points) : points_(points) {}

    bool begin(std::vector<uint32_t>& order);
    void insert(uint32_t p);
    [[nodiscard]] std::vector<Tetrahedron> finite() const;

private:
    [[nodiscard]] Vector at(uint32_t p) const { return Vector(points_[p]); }
    /// Volume of the cell with vertex `slot` replaced by p.
    [[nodiscard]] Wide volumeWith(const Tetrahedron& cell, int slot, uint32_t p) const
    {
        std::array<Vector, 4> v;
        for (int i = 0; i < 4; ++i) v[std::size_t(i)] = at(i == slot ? p : cell.vertex[std::size_t(i)]);
        return volume(v[0], v[1], v[2], v[3]);
    }
    [[nodiscard]] static int slotOf(const std::array<uint32_t, 4>& values, uint32_t value)
    {
        return int(std::find(values.begin(), values.end(), value) - values.begin());
    }
    [[nodiscard]] bool inSphere(const Tetrahedron& cell, uint32_t p) const;
    [[nodiscard]] bool conflicts(const Tetrahedron& cell, uint32_t p) const;
    [[nodiscard]] uint32_t locate(uint32_t p) const;

    struct BoundaryFace {
        Tetrahedron cell; ///< the new one: the old vertices with the point in `slot`
        int slot;
        uint32_t beyond; ///< the neighbour that stays, and the slot of this face there
        int beyondSlot;
    };
    struct Edge {
        uint64_t key;
        uint32_t cell;
        int slot;
    };

    std::span<const ivec3> points_;
    std::vector<Tetrahedron> cells_;
    std::vector<uint32_t> marks_; ///< 2 round: looked at, stays; 2 round + 1: in conflict
    uint32_t round_ = 0;
    uint32_t last_ = 0;
    std::vector<uint32_t> free_; ///< places of dead cells, whose vertices are all kInfinite
    std::vector<uint32_t> conflict_;
    std::vector<BoundaryFace> boundary_;
    std::vector<Edge> edges_;
};

// With p as the origin, p is inside the sphere when the hyperplane of the four lifted vertices passes above p's own
// lifted point, which is 0: sum of barycentric weight × squared distance > 0. A tie is broken by the derivative of that
// sum, towards the vertex that is lowered most among those that have a say.
bool Builder::inSphere(const Tetrahedron& cell, uint32_t p) const
{
    std::array<Wide, 4> volumes;
    Wide sum = 0;
    for (int i = 0; i < 4; ++i) {
        volumes[std::size_t(i)] = volumeWith(cell, i, p);
        const Vector d = at(cell.vertex[std::size_t(i)]) - at(p);
        sum += volumes[std::size_t(i)] * Wide(d.x * d.x + d.y * d.y + d.z * d.z);
    }
    if (sum != 0) return sum > 0;
    uint32_t highest = p;
    bool inside = true; // lowering p puts it below the hyperplane
    for (int i = 0; i < 4; ++i) {
        const uint32_t vertex = cell.vertex[std::size_t(i)];
        if (volumes[std::size_t(i)] == 0 || vertex < highest) continue;
        highest = vertex;
        inside = volumes[std::size_t(i)] < 0;
    }
    return inside;
}

bool Builder::conflicts(const Tetrahedron& cell, uint32_t p) const
{
    const int slot = slotOf(cell.vertex, kInfinite);
    if (slot == 4) return inSphere(cell, p);
    const Wide side = volumeWith(cell, slot, p);
    if (side != 0) return side > 0;
    return inSphere(cells_[cell.neighbor[std::size_t(slot)]], p); // in the hull face's plane: as the cell within
}

// Visibility walk (Devillers, Pion and Teillaud 2002, "Walking in a Triangulation"); it ends in Delaunay cells, with
// exact signs.
uint32_t Builder::locate(uint32_t p) const
{
    uint32_t current = last_;
    if (const int slot = slotOf(cells_[current].vertex, kInfinite); slot < 4)
        current = cells_[current].neighbor[std::size_t(slot)];
    uint32_t from = kOutside;
    for (;;) {
        const Tetrahedron& cell = cells_[current];
        uint32_t next = kOutside;
        for (int i = 0; i < 4 && next == kOutside; ++i) {
            const uint32_t neighbor = cell.neighbor[std::size_t(i)];
            if (neighbor != from && volumeWith(cell, i, p) < 0) next = neighbor;
        }
        if (next == kOutside) return current;
        if (slotOf(cells_[next].vertex, kInfinite) < 4) return next;
        from = std::exchange(current, next);
    }
}

/// The first cell, of four points not in a plane, which leave `order`. False when there are none.
bool Builder::begin(std::vector<uint32_t>& order)
{
    if (order.size() < 4) return false;
    std::array<std::size_t, 4> pick{0, 1, 0, 0};
    const Vector a = at(order[0]);
    const Vector ab = at(order[1]) - a;
    Vector normal(0);
    for (pick[2] = 2; pick[2] < order.size(); ++pick[2]) {
        normal = cross(ab, at(order[pick[2]]) - a);
        if (normal != Vector(0)) break;
    }
    if (pick[2] == order.size()) return false;
    for (pick[3] = pick[2] + 1; pick[3] < order.size(); ++pick[3]) {
        if (volume(a, at(order[1]), at(order[pick[2]]), at(order[pick[3]])) != 0) break;
    }
    if (pick[3] == order.size()) return false;

    Tetrahedron cell{{order[0], order[1], order[pick[2]], order[pick[3]]}, {1, 2, 3, 4}};
    if (volumeWith(cell, 0, order[0]) < 0) std::swap(cell.vertex[0], cell.vertex[1]);
    cells_ = {cell};
    for (std::size_t i = 0; i < 4; ++i) {
        // The cell beyond face i. Two vertices swapped: seen from outside, the face turns the other way.
        Tetrahedron beyond = cell;
        beyond.vertex[i] = kInfinite;
        for (std::size_t j = 0; j < 4; ++j) beyond.neighbor[j] = uint32_t(j == i ? 0 : j + 1);
        const std::size_t j = (i + 1) % 4;
        const std::size_t k = (i + 2) % 4;
        std::swap(beyond.vertex[j], beyond.vertex[k]);
        std::swap(beyond.neighbor[j], beyond.neighbor[k]);
        cells_.push_back(beyond);
    }
    marks_.assign(cells_.size(), 0);
    for (int i = 3; i >= 0; --i) order.erase(order.begin() + std::ptrdiff_t(pick[std::size_t(i)]));
    return true;
}

void Builder::insert(uint32_t p)
{
    // The cells whose sphere holds p, found from the one around it: a ball without holes.
    ++round_;
    const uint32_t stays = 2 * round_;
    const uint32_t goes = stays + 1;
    conflict_ = {locate(p)};
    marks_[conflict_[0]] = goes;
    boundary_.clear();
    for (std::size_t k = 0; k < conflict_.size(); ++k) {
        const uint32_t current = conflict_[k];
        for (int i = 0; i < 4; ++i) {
            const uint32_t beyond = cells_[current].neighbor[std::size_t(i)];
            if (marks_[beyond] < stays) {
                marks_[beyond] = conflicts(cells_[beyond], p) ? goes : stays;
                if (marks_[beyond] == goes) conflict_.push_back(beyond);
            }
            if (marks_[beyond] == goes) continue;
            BoundaryFace face{cells_[current], i, beyond, slotOf(cells_[beyond].neighbor, current)};
            face.cell.vertex[std::size_t(i)] = p;
            boundary_.push_back(face);
        }
    }

    for (const uint32_t dead : conflict_) cells_[dead].vertex.fill(kInfinite);
    free_.insert(free_.end(), conflict_.rbegin(), conflict_.rend());

    // In their place, p joined to every face of the ball, neighbours across the edges of those faces.
    edges_.clear();
    for (std::size_t k = 0; k < boundary_.size(); ++k) {
        BoundaryFace& face = boundary_[k];
        if (free_.empty()) {
            free_.push_back(uint32_t(cells_.size()));
            cells_.emplace_back();
            marks_.push_back(0);
        }
        const uint32_t id = free_.back();
        free_.pop_back();
        face.cell.neighbor[std::size_t(face.slot)] = face.beyond;
        cells_[face.beyond].neighbor[std::size_t(face.beyondSlot)] = id;
        cells_[id] = face.cell;
        marks_[id] = 0;
        for (int j = 0; j < 4; ++j) {
            if (j == face.slot) continue;
            std::array<uint32_t, 2> ends{};
            std::size_t count = 0;
            for (int i = 0; i < 4; ++i) {
                if (i != j && i != face.slot) ends[count++] = face.cell.vertex[std::size_t(i)];
            }
            if (ends[0] > ends[1]) std::swap(ends[0], ends[1]);
            edges_.push_back({uint64_t(ends[0]) << 32 | ends[1], id, j});
        }
        last_ = id;
    }
    std::sort(edges_.begin(), edges_.end(),
              [](const Edge& a, const Edge& b) { return std::tie(a.key, a.cell) < std::tie(b.key, b.cell); });
    assert(edges_.size() % 2 == 0);
    for (std::size_t k = 0; k + 1 < edges_.size(); k += 2) {
        assert(edges_[k].key == edges_[k + 1].key);
        cells_[edges_[k].cell].neighbor[std::size_t(edges_[k].slot)] = edges_[k + 1].cell;
        cells_[edges_[k + 1].cell].neighbor[std::size_t(edges_[k + 1].slot)] = edges_[k].cell;
    }
}

std::vector<Tetrahedron> Builder::finite() const
{
    std::vector<uint32_t> place(cells_.size(), kOutside);
    uint32_t count = 0;
    for (std::size_t i = 0; i < cells_.size(); ++i) {
        if (slotOf(cells_[i].vertex, kInfinite) == 4) place[i] = count++;
    }
    std::vector<Tetrahedron> result;
    result.reserve(count);
    for (std::size_t i = 0; i < cells_.size(); ++i) {
        if (place[i] == kOutside) continue;
        Tetrahedron cell = cells_[i];
        for (uint32_t& neighbor : cell.neighbor) neighbor = place[neighbor];
        result.push_back(cell);
    }
    return result;
}

} // namespace

std::vector<Tetrahedron> tetrahedralize(std::span<const ivec3> points)
{
    std::vector<uint32_t> order = insertionOrder(points);
    Builder builder(points);
    if (!builder.begin(order)) return {};
    for (const uint32_t p : order) builder.insert(p);
    return builder.finite();
}

} // namespace halflight
