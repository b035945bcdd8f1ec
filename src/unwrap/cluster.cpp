#include "unwrap/cluster.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <queue>
#include <unordered_map>

namespace halflight::charts {
namespace {

/// Merged regions may lose this share of their area when projected along their mean normal (a spherical cap of 44
/// degrees, a cylinder sector of 56); what can be flattened beyond that is for the merging of charts to find out.
constexpr double kMostFlatnessLost = 0.15;
/// Mean of 1 - cos(angle between the normals) along a border that may be merged away: about 50 degrees.
constexpr double kMostBend = 0.36;
/// No normal leaves a region's mean normal by more than this.
constexpr double kWidestConeRadians = 1.3;
constexpr double kCoplanarCosine = 1.0 - 1e-9;

struct Border {
    double length = 0.0;
    double bend = 0.0; ///< integral of 1 - cos along it
};

struct NormalCone {
    dvec3 axis{0.0};
    double angle = 0.0;
};

/// Smallest cone around two cones.
NormalCone merged(const NormalCone& a, const NormalCone& b)
{
    const double between = std::acos(std::clamp(glm::dot(a.axis, b.axis), -1.0, 1.0));
    if (between + b.angle <= a.angle) return a;
    if (between + a.angle <= b.angle) return b;
    const double angle = 0.5 * (a.angle + b.angle + between);
    const dvec3 aside = b.axis - glm::dot(a.axis, b.axis) * a.axis;
    const double asideLength = glm::length(aside);
    if (angle >= 3.1 || asideLength < 1e-12) return {a.axis, std::max(angle, a.angle)};
    const double turn = angle - a.angle;
    return {std::cos(turn) * a.axis + std::sin(turn) / asideLength * aside, angle};
}

struct Region {
    dvec3 vectorArea{0.0};
    double area = 0.0;
    double perimeter = 0.0;
    NormalCone cone;
    std::unordered_map<uint32_t, Border> borders; ///< by neighbouring region
};

struct Candidate {
    double cost;
    uint32_t a, b;
    bool operator<(const Candidate& other) const // std::priority_queue takes the greatest first
    {
        if (cost != other.cost) return cost > other.cost;
        return a != other.a ? a > other.a : b > other.b;
    }
};

class Clustering {
public:
    explicit Clustering(const Surface& surface) : surface_(surface), parent_(surface.triangleCount())
    {
        std::iota(parent_.begin(), parent_.end(), 0u);
    }

    Regions run()
    {
        mergeCoplanar();
        buildRegions();
        while (!queue_.empty()) {
            const Candidate candidate = queue_.top();
            queue_.pop();
            const uint32_t a = find(candidate.a), b = find(candidate.b);
            if (a == b) continue;
            // Costs change as regions grow; a candidate is put right when its turn comes.
            const double cost = mergeCost(a, b);
            if (cost >= kForbidden) continue;
            if (a != candidate.a || b != candidate.b || cost > candidate.cost * (1.0 + 1e-12)) {
                if (cost > candidate.cost) {
                    push(a, b, cost);
                    continue;
                }
            }
            merge(a, b);
        }
        return numbered();
    }

private:
    static constexpr double kForbidden = 1e30;

    uint32_t find(uint32_t t)
    {
        while (parent_[t] != t) t = parent_[t] = parent_[parent_[t]];
        return t;
    }

    template<typename Visit> void forEachPair(Visit visit)
    {
        for (uint32_t half = 0; half < surface_.neighbors.size(); ++half) {
            const uint32_t other = surface_.neighbors[half];
            if (other != kNone && half < other) visit(half / 3, other / 3, half);
        }
    }

    void mergeCoplanar()
    {
        forEachPair([&](uint32_t s, uint32_t t, uint32_t) {
            if (glm::dot(surface_.normals[s], surface_.normals[t]) < kCoplanarCosine) return;
            const uint32_t a = find(s), b = find(t);
            parent_[std::max(a, b)] = std::min(a, b);
        });
    }

    void buildRegions()
    {
        slot_.assign(surface_.triangleCount(), kNone);
        for (uint32_t t = 0; t < surface_.triangleCount(); ++t) {
            if (surface_.degenerate(t)) continue;
            const uint32_t root = find(t);
            if (slot_[root] == kNone) {
                slot_[root] = uint32_t(regions_.size());
                regions_.emplace_back().cone.axis = surface_.normals[t];
            }
            Region& region = regions_[slot_[root]];
            region.vectorArea += surface_.areas[t] * surface_.normals[t];
            region.area += surface_.areas[t];
            for (int k = 0; k < 3; ++k) {
                const uint32_t other = surface_.neighbors[3 * t + k];
                if (other == kNone || find(other / 3) != root) region.perimeter += edgeLength(3 * t + k);
            }
        }
        forEachPair([&](uint32_t s, uint32_t t, uint32_t half) {
            const uint32_t a = find(s), b = find(t);
            if (a == b) return;
            const double length = edgeLength(half);
            const double bend = length * (1.0 - glm::dot(surface_.normals[s], surface_.normals[t]));
            for (const auto& [from, to] : {std::pair{a, b}, std::pair{b, a}}) {
                Border& border = regions_[slot_[from]].borders[to];
                border.length += length;
                border.bend += bend;
            }
        });
        for (uint32_t t = 0; t < surface_.triangleCount(); ++t) {
            if (slot_[t] == kNone || find(t) != t) continue;
            for (const auto& [other, border] : regions_[slot_[t]].borders) {
                if (t < other) push(t, other, mergeCost(t, other));
            }
        }
    }

    [[nodiscard]] double edgeLength(uint32_t half) const
    {
        const uvec3& triangle = surface_.triangles[half / 3];
        return glm::distance(surface_.positions[triangle[half % 3]], surface_.positions[triangle[(half + 1) % 3]]);
    }

    void push(uint32_t a, uint32_t b, double cost)
    {
        if (cost < kForbidden) queue_.push({cost, std::min(a, b), std::max(a, b)});
    }

    double mergeCost(uint32_t a, uint32_t b)
    {
        const Region &ra = regions_[slot_[a]], &rb = regions_[slot_[b]];
        const auto found = ra.borders.find(b);
        if (found == ra.borders.end()) return kForbidden;
        const Border& border = found->second;
        const double bend = border.length > 0.0 ? border.bend / border.length : 0.0;
        const double flatnessLost = 1.0 - glm::length(ra.vectorArea + rb.vectorArea) / (ra.area + rb.area);
        if (bend > kMostBend || flatnessLost > kMostFlatnessLost) return kForbidden;
        if (merged(ra.cone, rb.cone).angle > kWidestConeRadians) return kForbidden;
        const double ragged = 1.0 - border.length / std::max(std::min(ra.perimeter, rb.perimeter), 1e-300);
        return flatnessLost + 0.3 * bend + 0.02 * std::max(ragged, 0.0);
    }

    /// The region with more borders stays: each border moves at most log(n) times.
    void merge(uint32_t a, uint32_t b)
    {
        if (regions_[slot_[a]].borders.size() < regions_[slot_[b]].borders.size()) std::swap(a, b);
        Region &into = regions_[slot_[a]], &from = regions_[slot_[b]];
        const double shared = into.borders[b].length;
        into.borders.erase(b);
        into.vectorArea += from.vectorArea;
        into.area += from.area;
        into.perimeter = std::max(into.perimeter + from.perimeter - 2.0 * shared, 0.0);
        into.cone = merged(into.cone, from.cone);
        parent_[b] = a;
        for (const auto& [other, border] : from.borders) {
            if (other == a) continue;
            Border& mine = into.borders[other];
            mine.length += border.length;
            mine.bend += border.bend;
            auto& theirs = regions_[slot_[other]].borders;
            theirs.erase(b);
            theirs[a] = mine;
        }
        for (const auto& [other, border] : from.borders) {
            if (other != a) push(a, other, mergeCost(a, other));
        }
        from.borders = {};
    }

    Regions numbered()
    {
        Regions result;
        result.ofTriangle.assign(surface_.triangleCount(), kNone);
        std::vector<uint32_t> number(surface_.triangleCount(), kNone);
        for (uint32_t t = 0; t < surface_.triangleCount(); ++t) {
            if (surface_.degenerate(t)) continue;
            uint32_t& n = number[find(t)];
            if (n == kNone) n = result.count++;
            result.ofTriangle[t] = n;
        }
        return result;
    }

    const Surface& surface_;
    std::vector<uint32_t> parent_;
    std::vector<uint32_t> slot_; ///< region of a root triangle
    std::vector<Region> regions_;
    std::priority_queue<Candidate> queue_;
};

} // namespace

Regions clusterTriangles(const Surface& surface)
{
    return Clustering(surface).run();
}

} // namespace halflight::charts
