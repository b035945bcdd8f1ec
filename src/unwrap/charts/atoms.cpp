#include "unwrap/charts/atoms.h"

#include "halflight/base/parallel.h"
#include "halflight/shading/random.h"
#include "unwrap/surface/region.h"

#include <algorithm>

namespace halflight::charts {
namespace {

/// Flat to 2 %, so that a fan of triangles stands for an atom; outlines count for more than in charts, since a fan
/// wants a compact one.
constexpr JoinRules kAtomRules{0.1, 0.36, kAnyCone, 0.0, 0.02};
constexpr std::size_t kAtomGrain = 2048;

struct Atom {
    RegionMeasure measure;
    uint32_t triangles = 1;
};

struct Link {
    uint32_t to;
    Border border;
};

/// Atoms and who borders on whom, as one list of links in the order of the atoms.
class Gathering {
public:
    Gathering(const Surface& surface, uint32_t mostTriangles) : mostTriangles_(mostTriangles)
    {
        result_.ofTriangle.assign(surface.triangleCount(), kNone);
        for (uint32_t t = 0; t < surface.triangleCount(); ++t) {
            if (!surface.degenerate(t)) result_.ofTriangle[t] = result_.count++;
        }
        atoms_.resize(result_.count);
        start_.push_back(0);
        for (uint32_t t = 0; t < surface.triangleCount(); ++t) {
            if (surface.degenerate(t)) continue;
            RegionMeasure& measure = atoms_[result_.ofTriangle[t]].measure;
            measure.vectorArea = surface.areas[t] * surface.normals[t];
            measure.area = surface.areas[t];
            measure.cone.axis = surface.normals[t];
            for (int k = 0; k < 3; ++k) {
                const double length = glm::distance(surface.corner(t, k), surface.corner(t, (k + 1) % 3));
                measure.perimeter += length;
                const uint32_t other = surface.neighbors[3 * t + uint32_t(k)];
                if (other == kNone) continue;
                const double bend = 1.0 - glm::dot(surface.normals[t], surface.normals[other / 3]);
                links_.push_back({result_.ofTriangle[other / 3], {length, length * bend}});
            }
            start_.push_back(uint32_t(links_.size()));
        }
    }

    Atoms run(const Progress& progress)
    {
        constexpr int kMostRounds = 64;
        for (int round = 0; round < kMostRounds && !progress.cancelled(); ++round) {
            const std::size_t before = atoms_.size();
            chooseBest();
            contract();
            if (50 * (before - atoms_.size()) <= before) break;
        }
        return std::move(result_);
    }

private:
    void chooseBest()
    {
        best_.assign(atoms_.size(), kNone);
        parallelFor(atoms_.size(), kAtomGrain, [&](std::size_t begin, std::size_t end) {
            for (auto a = uint32_t(begin); a < end; ++a) {
                double bestCost = kForbidden;
                uint32_t bestTie = 0;
                for (uint32_t i = start_[a]; i < start_[a + 1]; ++i) {
                    const uint32_t b = links_[i].to, low = std::min(a, b), high = std::max(a, b);
                    if (a == b || atoms_[a].triangles + atoms_[b].triangles > mostTriangles_) continue;
                    const double cost = kAtomRules.cost(atoms_[low].measure, atoms_[high].measure, links_[i].border);
                    if (cost > bestCost || cost >= kForbidden) continue;
                    // In a regular grid all costs are equal: without a shuffle everyone would look the same way.
                    const uint32_t tie = hashCombine(low, high);
                    if (cost == bestCost && best_[a] != kNone && tie >= bestTie) continue;
                    bestCost = cost;
                    bestTie = tie;
                    best_[a] = b;
                }
            }
        });
    }

    void contract()
    {
        const auto partner = [&](uint32_t a) { return best_[a] != kNone && best_[best_[a]] == a ? best_[a] : kNone; };
        std::vector<uint32_t> number(atoms_.size()), lead;
        std::vector<uint32_t> roomStart{0};
        for (uint32_t a = 0; a < atoms_.size(); ++a) {
            const uint32_t other = partner(a);
            if (other != kNone && other < a) {
                number[a] = number[other];
                continue;
            }
            number[a] = uint32_t(lead.size());
            lead.push_back(a);
            uint32_t room = start_[a + 1] - start_[a];
            if (other != kNone) room += start_[other + 1] - start_[other];
            roomStart.push_back(roomStart.back() + room);
        }
        std::vector<Atom> atoms(lead.size());
        std::vector<Link> room(roomStart.back());
        std::vector<uint32_t> start(lead.size() + 1, 0);
        parallelFor(lead.size(), kAtomGrain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t n = begin; n < end; ++n) {
                const uint32_t a = lead[n], b = partner(a);
                atoms[n] = atoms_[a];
                double shared = 0.0;
                Link* const first = room.data() + roomStart[n];
                Link* last = first;
                for (const uint32_t member : {a, b}) {
                    if (member == kNone) continue;
                    for (uint32_t i = start_[member]; i < start_[member + 1]; ++i) {
                        const uint32_t to = number[links_[i].to];
                        if (to != n)
                            *last++ = {to, links_[i].border};
                        else if (member == a)
                            shared += links_[i].border.length;
                    }
                }
                if (b != kNone) {
                    atoms[n].measure.join(atoms_[b].measure, shared);
                    atoms[n].triangles += atoms_[b].triangles;
                }
                std::sort(first, last, [](const Link& x, const Link& y) {
                    return x.to != y.to ? x.to < y.to : x.border.length < y.border.length;
                });
                Link* out = first;
                for (const Link* link = first; link != last; ++link) {
                    if (out != first && (out - 1)->to == link->to) {
                        (out - 1)->border.length += link->border.length;
                        (out - 1)->border.bend += link->border.bend;
                    } else {
                        *out++ = *link;
                    }
                }
                start[n + 1] = uint32_t(out - first);
            }
        });
        for (std::size_t n = 0; n < lead.size(); ++n) start[n + 1] += start[n];
        links_.resize(start.back());
        parallelFor(lead.size(), kAtomGrain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t n = begin; n < end; ++n) {
                std::copy_n(room.data() + roomStart[n], start[n + 1] - start[n], links_.data() + start[n]);
            }
        });
        parallelFor(result_.ofTriangle.size(), 16 * kAtomGrain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t t = begin; t < end; ++t) {
                if (result_.ofTriangle[t] != kNone) result_.ofTriangle[t] = number[result_.ofTriangle[t]];
            }
        });
        start_ = std::move(start);
        atoms_ = std::move(atoms);
        result_.count = uint32_t(atoms_.size());
    }

    uint32_t mostTriangles_;
    Atoms result_;
    std::vector<Atom> atoms_;
    std::vector<uint32_t> start_; ///< of an atom's links; one more at the end
    std::vector<Link> links_;
    std::vector<uint32_t> best_;
};

} // namespace

Atoms gatherAtoms(const Surface& surface, uint32_t mostTriangles, const Progress& progress)
{
    return Gathering(surface, mostTriangles).run(progress);
}

} // namespace halflight::charts
