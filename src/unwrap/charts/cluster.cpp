#include "unwrap/charts/cluster.h"

#include "unwrap/surface/region.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <queue>
#include <unordered_map>

namespace halflight::charts {
namespace {

/// Merged regions may lose 15 % of their area when projected along their mean normal (a spherical cap of 44 degrees, a
/// cylinder sector of 56); what can be flattened beyond that is for the merging of charts to find out. Borders that
/// bend by more than about 50 degrees stay.
constexpr JoinRules kRules{0.15, 0.36, 1.3, 0.02};
constexpr double kCoplanarCosine = 1.0 - 1e-9;

struct Region {
    RegionMeasure measure;
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
    Clustering(const Surface& surface, std::span<const uint32_t> together)
        : surface_(surface), parent_(together.begin(), together.end())
    {
        if (!parent_.empty()) return;
        parent_.resize(surface.triangleCount());
        std::iota(parent_.begin(), parent_.end(), 0u);
        mergeCoplanar();
    }

    Regions run(const Progress& progress)
    {
        buildRegions();
        while (!queue_.empty() && !progress.cancelled()) {
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
                regions_.emplace_back().measure.cone.axis = surface_.normals[t];
            }
            RegionMeasure& region = regions_[slot_[root]].measure;
            region.vectorArea += surface_.areas[t] * surface_.normals[t];
            region.area += surface_.areas[t];
            if (glm::dot(region.cone.axis, surface_.normals[t]) < kCoplanarCosine)
                region.cone = merged(region.cone, {surface_.normals[t], 0.0});
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
        return kRules.cost(ra.measure, rb.measure, found->second);
    }

    /// The region with more borders stays: each border moves at most log(n) times.
    void merge(uint32_t a, uint32_t b)
    {
        if (regions_[slot_[a]].borders.size() < regions_[slot_[b]].borders.size()) std::swap(a, b);
        Region &into = regions_[slot_[a]], &from = regions_[slot_[b]];
        const double shared = into.borders[b].length;
        into.borders.erase(b);
        into.measure.join(from.measure, shared);
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

Regions clusterTriangles(const Surface& surface, std::span<const uint32_t> together, const Progress& progress)
{
    return Clustering(surface, together).run(progress);
}

} // namespace halflight::charts
