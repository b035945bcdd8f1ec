#include "unwrap/charts/coarse.h"

#include "halflight/base/parallel.h"
#include "unwrap/charts/atoms.h"
#include "unwrap/charts/split_triangles.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>

namespace halflight::charts {
namespace {

constexpr std::size_t kGrain = 256;
/// A rim leaves an outline by at most this share of the outline's length.
constexpr double kRimTolerance = 0.2;

/// From atoms to fans. An atom whose outline is not one loop, or that its centroid does not see all of, is cut in two.
class Coarsening {
public:
    Coarsening(const Surface& fine, const Progress& progress) : fine_(fine), progress_(progress)
    {
        // Enough atoms to tell charts apart by, about six coarse triangles each.
        constexpr uint32_t kAtomsWanted = 3000, kSmallest = 32, kLargest = 1024;
        const auto wanted = uint32_t(fine.triangleCount() / kAtomsWanted);
        Atoms atoms = gatherAtoms(fine, std::clamp(wanted, kSmallest, kLargest), progress);
        result_.atomOfTriangle = std::move(atoms.ofTriangle);
        count_ = atoms.count;
    }

    CoarseSurface run()
    {
        if (progress_.cancelled()) return {};
        listMembers();
        cutWhile([&](std::size_t a) { return !hasOneLoop(a); }, ~0u);
        // A fan that still faces the wrong way somewhere only keeps its atom from being joined to others.
        constexpr int kTries = 6;
        for (int i = 0; i < kTries; ++i) {
            if (progress_.cancelled()) return {};
            findRims();
            if (!cutWhile([&](std::size_t a) { return !hubOf(a).seesAll; }, 1)) break;
            cutWhile([&](std::size_t a) { return !hasOneLoop(a); }, ~0u);
            if (i + 1 == kTries) findRims();
        }
        if (progress_.cancelled()) return {}; // atoms may be what cutting has not got to
        drawFans();
        return std::move(result_);
    }

private:
    [[nodiscard]] std::span<const uint32_t> members(std::size_t atom) const
    {
        return std::span(members_).subspan(memberStart_[atom], memberStart_[atom + 1] - memberStart_[atom]);
    }

    void listMembers()
    {
        memberStart_.assign(count_ + 1, 0);
        for (const uint32_t atom : result_.atomOfTriangle) {
            if (atom != kNone) ++memberStart_[atom + 1];
        }
        for (uint32_t a = 0; a < count_; ++a) memberStart_[a + 1] += memberStart_[a];
        members_.resize(memberStart_.back());
        std::vector<uint32_t> fill(memberStart_.begin(), memberStart_.end() - 1);
        for (uint32_t t = 0; t < result_.atomOfTriangle.size(); ++t) {
            if (result_.atomOfTriangle[t] != kNone) members_[fill[result_.atomOfTriangle[t]]++] = t;
        }
    }

    [[nodiscard]] uint32_t atomOfHalf(uint32_t half) const { return result_.atomOfTriangle[half / 3]; }
    [[nodiscard]] bool onOutline(uint32_t half) const
    {
        const uint32_t other = fine_.neighbors[half];
        return other == kNone || atomOfHalf(other) != atomOfHalf(half);
    }
    static uint32_t following(uint32_t half) { return half - half % 3 + (half % 3 + 1) % 3; }
    /// The half edge of the atom's outline that begins where this one ends.
    [[nodiscard]] uint32_t nextOnOutline(uint32_t half) const
    {
        uint32_t next = following(half);
        while (!onOutline(next)) next = following(fine_.neighbors[next]);
        return next;
    }
    [[nodiscard]] dvec3 startOf(uint32_t half) const { return fine_.corner(half / 3, int(half % 3)); }
    [[nodiscard]] dvec3 endOf(uint32_t half) const { return startOf(following(half)); }

    /// The atom's outline from its first half edge on; of several loops, the first.
    [[nodiscard]] std::vector<uint32_t> outline(std::size_t atom) const
    {
        std::vector<uint32_t> loop;
        for (const uint32_t t : members(atom)) {
            for (uint32_t half = 3 * t; half < 3 * t + 3 && loop.empty(); ++half) {
                if (!onOutline(half)) continue;
                for (uint32_t h = half; loop.empty() || h != half; h = nextOnOutline(h)) loop.push_back(h);
            }
            if (!loop.empty()) break;
        }
        return loop;
    }

    [[nodiscard]] bool hasOneLoop(std::size_t atom) const
    {
        std::size_t edges = 0;
        for (const uint32_t t : members(atom)) {
            for (uint32_t half = 3 * t; half < 3 * t + 3; ++half) edges += onOutline(half);
        }
        return edges > 0 && outline(atom).size() == edges;
    }

    /// Puts a rim vertex at the end of a half edge of an outline, and the same on the other side.
    void breakAfter(std::vector<uint8_t>& breaks, uint32_t half, uint32_t next) const
    {
        breaks[half] = 1;
        if (fine_.neighbors[next] != kNone) breaks[fine_.neighbors[next]] = 1;
    }

    /// The vertices at which outlines are followed: where the neighbour changes, and then wherever a line between two
    /// of them would leave the outline by too much (Douglas and Peucker 1973). Both sides of an outline get the same.
    void findRims()
    {
        std::vector<uint8_t> changes(fine_.neighbors.size(), 0);
        parallelFor(count_, kGrain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t a = begin; a < end; ++a) {
                for (const uint32_t half : outline(a)) {
                    const uint32_t next = nextOnOutline(half);
                    const uint32_t other = fine_.neighbors[half], otherNext = fine_.neighbors[next];
                    const bool goesOn =
                        other == kNone || otherNext == kNone
                            ? other == otherNext
                            : atomOfHalf(other) == atomOfHalf(otherNext) && nextOnOutline(otherNext) == other;
                    changes[half] = !goesOn;
                }
            }
        });
        breaks_ = changes;
        parallelFor(count_, kGrain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t a = begin; a < end; ++a) {
                std::vector<uint32_t> loop = outline(a);
                const auto first =
                    std::find_if(loop.begin(), loop.end(), [&](uint32_t half) { return changes[half] != 0; });
                if (first != loop.end()) {
                    std::rotate(loop.begin(), first + 1, loop.end());
                } else if (isOwner(a, loop[0])) { // one neighbour all round
                    breakAfter(breaks_, loop.back(), loop[0]);
                }
                for (std::size_t from = 0, to = 0; from < loop.size(); from = to) {
                    for (to = from + 1; to < loop.size() && !changes[loop[to - 1]];) ++to;
                    if (isOwner(a, loop[from])) follow(std::span(loop).subspan(from, to - from));
                }
            }
        });
        // A fan has three triangles at least.
        for (std::size_t a = 0; a < count_; ++a) {
            const std::vector<uint32_t> loop = outline(a);
            auto corners = std::count_if(loop.begin(), loop.end(), [&](uint32_t half) { return breaks_[half] != 0; });
            for (std::size_t i = 0; i < loop.size() && corners < 3; ++i) {
                const std::size_t at = i * loop.size() / 3 % loop.size(); // thirds first
                const std::size_t place = i < 3 ? at : i;
                if (breaks_[loop[place]]) continue;
                breakAfter(breaks_, loop[place], loop[(place + 1) % loop.size()]);
                ++corners;
            }
        }
    }

    /// Of the two atoms at an outline, one says how it is followed.
    [[nodiscard]] bool isOwner(std::size_t atom, uint32_t half) const
    {
        const uint32_t other = fine_.neighbors[half];
        return other == kNone || atom < atomOfHalf(other);
    }

    void follow(std::span<const uint32_t> chain)
    {
        if (chain.size() < 2) return;
        const dvec3 from = startOf(chain.front()), to = endOf(chain.back());
        const double squared = glm::dot(to - from, to - from);
        double length = glm::distance(from, endOf(chain.front())), farthest = -1.0;
        std::size_t at = 0;
        for (std::size_t i = 0; i + 1 < chain.size(); ++i) {
            const dvec3 p = endOf(chain[i]);
            length += glm::distance(p, endOf(chain[i + 1]));
            const double along = squared > 0.0 ? std::clamp(glm::dot(p - from, to - from) / squared, 0.0, 1.0) : 0.0;
            const double distance = glm::distance(p, from + along * (to - from));
            if (distance > farthest) {
                farthest = distance;
                at = i;
            }
        }
        if (!(farthest > kRimTolerance * length)) return;
        breakAfter(breaks_, chain[at], chain[at + 1]);
        follow(chain.subspan(0, at + 1));
        follow(chain.subspan(at + 1));
    }

    /// Runs of the outline between rim vertices: first and last half edge.
    [[nodiscard]] std::vector<std::pair<uint32_t, uint32_t>> rim(std::size_t atom) const
    {
        std::vector<uint32_t> loop = outline(atom);
        const auto first = std::find_if(loop.begin(), loop.end(), [&](uint32_t half) { return breaks_[half] != 0; });
        if (first != loop.end()) std::rotate(loop.begin(), first + 1, loop.end());
        std::vector<std::pair<uint32_t, uint32_t>> runs;
        bool open = false;
        for (const uint32_t half : loop) {
            if (!open) runs.emplace_back(half, half);
            runs.back().second = half;
            open = breaks_[half] == 0;
        }
        return runs;
    }

    [[nodiscard]] dvec3 centerOf(std::size_t atom) const
    {
        dvec3 sum(0.0);
        double area = 0.0;
        for (const uint32_t t : members(atom)) {
            sum += fine_.areas[t] / 3.0 * (fine_.corner(t, 0) + fine_.corner(t, 1) + fine_.corner(t, 2));
            area += fine_.areas[t];
        }
        return sum / area;
    }

    /// Where the triangles of a fan meet.
    struct Hub {
        dvec3 place;
        bool seesAll; ///< they all face the atom's way
    };

    /// The centroid; where it does not see all of the rim, it is pushed inwards from the side that it sees least of,
    /// and so on. When that does not help, the centroid.
    [[nodiscard]] Hub hubOf(std::size_t atom) const
    {
        constexpr int kPushes = 24;
        const auto runs = rim(atom);
        const dvec3 up = normalOf(atom), centroid = centerOf(atom);
        dvec3 center = centroid;
        for (int push = 0; push <= kPushes; ++push) {
            bool seesAll = runs.size() >= 3;
            dvec3 inwards(0.0);
            double worst = -1e300;
            for (const auto& [first, last] : runs) {
                const dvec3 a = startOf(first), b = endOf(last);
                const dvec3 cross = glm::cross(a - center, b - center);
                seesAll &= glm::dot(cross, up) > 0.3 * glm::length(cross);
                const dvec3 in = glm::cross(up, b - a);
                const double length = glm::length(in);
                if (!(length > 0.0)) continue;
                const double lack = 0.05 * length - glm::dot(in, center - a) / length;
                if (lack <= worst) continue;
                worst = lack;
                inwards = in / length;
            }
            if (seesAll) return {center, true};
            if (worst <= 0.0 || runs.size() < 3) break;
            center += 1.1 * worst * inwards;
        }
        return {centroid, false};
    }

    [[nodiscard]] dvec3 normalOf(std::size_t atom) const
    {
        dvec3 sum(0.0);
        for (const uint32_t t : members(atom)) sum += fine_.areas[t] * fine_.normals[t];
        const double length = glm::length(sum);
        return length > 0.0 ? sum / length : fine_.normals[members(atom)[0]];
    }

    /// Cuts in two what is bad, and what comes of it again. Returns whether anything was.
    template<typename IsBad> bool cutWhile(IsBad isBad, uint32_t mostRounds)
    {
        bool any = false;
        std::vector<uint32_t> asked(count_);
        std::iota(asked.begin(), asked.end(), 0u);
        for (uint32_t round = 0; round < mostRounds && !progress_.cancelled(); ++round) {
            std::vector<std::vector<std::vector<uint32_t>>> pieces(asked.size());
            parallelFor(asked.size(), kGrain, [&](std::size_t begin, std::size_t end) {
                for (std::size_t i = begin; i < end; ++i) {
                    if (members(asked[i]).size() > 1 && isBad(asked[i])) pieces[i] = halves(asked[i]);
                }
            });
            std::vector<uint32_t> next;
            for (std::size_t i = 0; i < asked.size(); ++i) {
                if (pieces[i].empty()) continue;
                next.push_back(asked[i]); // the first piece keeps the number
                for (std::size_t p = 1; p < pieces[i].size(); ++p) {
                    for (const uint32_t t : pieces[i][p]) result_.atomOfTriangle[t] = count_;
                    next.push_back(count_++);
                }
            }
            if (next.empty()) break;
            any = true;
            listMembers();
            asked = std::move(next);
        }
        return any;
    }

    [[nodiscard]] std::vector<std::vector<uint32_t>> halves(std::size_t atom) const
    {
        const std::vector<uint32_t> triangles(members(atom).begin(), members(atom).end());
        const auto farthest = [&](dvec3 from, uint32_t but) {
            uint32_t best = kNone;
            double most = -1.0;
            for (const uint32_t t : triangles) {
                const double distance = glm::distance(from, fine_.centroid(t));
                if (t == but || !(distance > most)) continue;
                most = distance;
                best = t;
            }
            return best;
        };
        const uint32_t one = farthest(centerOf(atom), kNone);
        const uint32_t two = farthest(fine_.corner(one, 0), one);
        std::vector<std::vector<uint32_t>> pieces;
        for (const auto& half : splitTriangles(fine_, triangles, one, two)) {
            for (auto& piece : connectedPieces(fine_, half)) pieces.push_back(std::move(piece));
        }
        return pieces;
    }

    void drawFans()
    {
        std::vector<std::vector<std::pair<uint32_t, uint32_t>>> rims(count_);
        parallelFor(count_, kGrain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t a = begin; a < end; ++a) rims[a] = rim(a);
        });
        result_.fanStart.assign(1, 0);
        for (const auto& runs : rims) result_.fanStart.push_back(result_.fanStart.back() + uint32_t(runs.size()));
        const std::size_t triangles = result_.fanStart.back();
        Surface& coarse = result_.surface;
        coarse.positions.resize(count_ + triangles);
        coarse.triangles.resize(triangles);
        coarse.normals.resize(triangles);
        coarse.areas.resize(triangles);
        coarse.neighbors.assign(3 * triangles, kNone);
        std::vector<uint32_t> triangleOfRun(fine_.neighbors.size(), kNone); // by the run's first half edge
        for (uint32_t a = 0; a < count_; ++a) {
            for (uint32_t i = 0; i < rims[a].size(); ++i) triangleOfRun[rims[a][i].first] = result_.fanStart[a] + i;
        }
        parallelFor(count_, kGrain, [&](std::size_t begin, std::size_t end) {
            for (auto a = uint32_t(begin); a < end; ++a) {
                const uint32_t first = result_.fanStart[a], size = result_.fanStart[a + 1] - first;
                coarse.positions[a] = hubOf(a).place;
                for (uint32_t i = 0; i < size; ++i) {
                    const uint32_t t = first + i, next = first + (i + 1) % size;
                    coarse.positions[count_ + t] = startOf(rims[a][i].first);
                    coarse.triangles[t] = {a, count_ + t, count_ + next};
                    coarse.neighbors[3 * t + 2] = 3 * next;
                    coarse.neighbors[3 * next] = 3 * t + 2;
                    const uint32_t across = fine_.neighbors[rims[a][i].second];
                    if (across != kNone) coarse.neighbors[3 * t + 1] = 3 * triangleOfRun[across] + 1;
                    const dvec3 p = coarse.positions[a];
                    const dvec3 cross = glm::cross(startOf(rims[a][i].first) - p, endOf(rims[a][i].second) - p);
                    // Of a sliver nothing may be left; it stays a triangle.
                    const double doubleArea = glm::length(cross);
                    coarse.areas[t] = std::max(0.5 * doubleArea, 1e-6 * fine_.areas[members(a)[0]]);
                    coarse.normals[t] = doubleArea > 0.0 ? cross / doubleArea : fine_.normals[members(a)[0]];
                }
            }
        });
    }

    const Surface& fine_;
    const Progress& progress_;
    CoarseSurface result_;
    uint32_t count_ = 0;
    std::vector<uint32_t> members_, memberStart_;
    std::vector<uint8_t> breaks_; ///< by half edge: a rim vertex lies at its end
};

} // namespace

CoarseSurface coarsen(const Surface& fine, const Progress& progress)
{
    return Coarsening(fine, progress).run();
}

} // namespace halflight::charts
