#include "unwrap/charts/merge.h"

#include "halflight/base/parallel.h"

#include <algorithm>
#include <cmath>
#include <unordered_set>

namespace halflight::charts {
namespace {

/// A chart's L2 stretch may come to this by merging; a cap of a sphere that spans a third of it has 1.05.
constexpr double kMostStretch = 1.06;
/// Charts below the size of a texel may stretch more: their texels are averages anyway.
constexpr double kMostStretchOfSmall = 1.25;
/// Mean of 1 - cos(angle between normals) along a border that may vanish: about 50 degrees.
constexpr double kMostBend = 0.36;
/// A rectangle around the merged chart may hold this much more than those of the two charts.
constexpr double kMostRectangleGrowth = 1.35;
constexpr int kRounds = 16;

struct Pair {
    uint32_t a, b; ///< charts, a < b
    double length, bend;
    double worth; ///< share of the smaller chart's outline that vanishes
};

double edgeLength(const Surface& surface, uint32_t half)
{
    const uvec3& triangle = surface.triangles[half / 3];
    return glm::distance(surface.positions[triangle[half % 3]], surface.positions[triangle[(half + 1) % 3]]);
}

bool isSmall(const Chart& chart, double texelMeters)
{
    const double thickness = 2.0 * chart.area / std::max(chart.perimeter, 1e-300);
    return thickness < texelMeters || chart.area < 4.0 * texelMeters * texelMeters;
}

class Merging {
public:
    Merging(const Surface& surface, std::vector<Chart>& charts, std::vector<uint32_t>& chartOfTriangle,
            double texelMeters)
        : surface_(surface), charts_(charts), chartOfTriangle_(chartOfTriangle), texelMeters_(texelMeters)
    {}

    /// Every chart proposes to its best neighbour; proposals that touch no chart twice are tried at once, on all
    /// threads. Returns whether anything was merged.
    bool round(const Progress& progress)
    {
        std::vector<Pair> pairs = neighbours();
        std::stable_sort(pairs.begin(), pairs.end(), [](const Pair& x, const Pair& y) { return x.worth > y.worth; });
        std::vector<char> busy(charts_.size(), 0);
        std::vector<Pair> chosen;
        for (const Pair& pair : pairs) {
            if (busy[pair.a] || busy[pair.b]) continue;
            busy[pair.a] = busy[pair.b] = 1;
            chosen.push_back(pair);
        }
        std::vector<Flattening> results(chosen.size());
        parallelFor(chosen.size(), 8, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                if (!progress.cancelled()) results[i] = tryMerge(chosen[i]);
            }
        });
        for (std::size_t i = 0; i < chosen.size(); ++i) {
            const Pair& pair = chosen[i];
            if (!results[i].valid) {
                refused_.insert(keyOf(pair));
                continue;
            }
            charts_[pair.a] = std::move(results[i].chart);
            charts_[pair.b] = Chart();
            for (const uint32_t t : charts_[pair.a].triangles) chartOfTriangle_[t] = pair.a;
            ++version_[pair.a];
        }
        return !chosen.empty();
    }

    void prepare() { version_.assign(charts_.size(), 0); }

    /// Closes the gaps that merged charts left.
    void compact()
    {
        std::vector<uint32_t> number(charts_.size(), kNone);
        uint32_t count = 0;
        for (std::size_t c = 0; c < charts_.size(); ++c) {
            if (charts_[c].triangles.empty()) continue;
            number[c] = count;
            if (c != count) charts_[count] = std::move(charts_[c]);
            ++count;
        }
        charts_.resize(count);
        for (uint32_t& chart : chartOfTriangle_) {
            if (chart != kNone) chart = number[chart];
        }
    }

private:
    /// Changes when one of the charts does, so that a pair is tried again only then.
    [[nodiscard]] uint64_t keyOf(const Pair& pair) const
    {
        const uint64_t a = uint64_t(pair.a) << 12 | (version_[pair.a] & 0xfffu);
        const uint64_t b = uint64_t(pair.b) << 12 | (version_[pair.b] & 0xfffu);
        return (a * 0x9E3779B97F4A7C15ull) ^ (b * 0xBF58476D1CE4E5B9ull + 0x94D049BB133111EBull);
    }

    [[nodiscard]] std::vector<Pair> neighbours() const
    {
        std::vector<Pair> pairs;
        for (uint32_t half = 0; half < surface_.neighbors.size(); ++half) {
            const uint32_t other = surface_.neighbors[half];
            if (other == kNone || half > other) continue;
            const uint32_t a = chartOfTriangle_[half / 3], b = chartOfTriangle_[other / 3];
            if (a == b) continue;
            const double length = edgeLength(surface_, half);
            const double bend = 1.0 - glm::dot(surface_.normals[half / 3], surface_.normals[other / 3]);
            pairs.push_back({std::min(a, b), std::max(a, b), length, length * bend, 0.0});
        }
        std::stable_sort(pairs.begin(), pairs.end(),
                         [](const Pair& x, const Pair& y) { return x.a != y.a ? x.a < y.a : x.b < y.b; });
        std::vector<Pair> joined;
        for (const Pair& pair : pairs) {
            if (joined.empty() || joined.back().a != pair.a || joined.back().b != pair.b) {
                joined.push_back(pair);
            } else {
                joined.back().length += pair.length;
                joined.back().bend += pair.bend;
            }
        }
        std::erase_if(joined, [&](Pair& pair) { return !eligible(pair); });
        return joined;
    }

    [[nodiscard]] bool eligible(Pair& pair) const
    {
        const Chart &a = charts_[pair.a], &b = charts_[pair.b];
        if (!(pair.length > 0.0) || refused_.contains(keyOf(pair))) return false;
        const bool small = isSmall(a, texelMeters_) || isSmall(b, texelMeters_);
        // Across a sharp edge light differs: only what is small on both sides is averaged over it.
        const bool bothSmall = isSmall(a, texelMeters_) && isSmall(b, texelMeters_);
        if (!bothSmall && pair.bend > kMostBend * pair.length) return false;
        pair.worth = pair.length / std::min(a.perimeter, b.perimeter) - 0.25 * pair.bend / pair.length;
        return pair.worth > (small ? 0.02 : 0.1);
    }

    [[nodiscard]] Flattening tryMerge(const Pair& pair) const
    {
        const Chart &a = charts_[pair.a], &b = charts_[pair.b];
        std::vector<uint32_t> triangles;
        triangles.reserve(a.triangles.size() + b.triangles.size());
        std::merge(a.triangles.begin(), a.triangles.end(), b.triangles.begin(), b.triangles.end(),
                   std::back_inserter(triangles));
        Flattening result = flatten(surface_, std::move(triangles));
        if (!result.valid) return result;
        const bool small = isSmall(a, texelMeters_) || isSmall(b, texelMeters_);
        const double before = std::max({a.stretch, b.stretch, 1.0});
        const double most = std::max(small ? kMostStretchOfSmall : kMostStretch, 1.0001 * before);
        const double border = 3.0 * texelMeters_; // with what padding costs, small charts have large rectangles
        const auto rectangle = [&](const Chart& chart) { return (chart.size.x + border) * (chart.size.y + border); };
        if (result.chart.stretch > most ||
            rectangle(result.chart) > kMostRectangleGrowth * (rectangle(a) + rectangle(b))) {
            result.valid = false;
        }
        return result;
    }

    const Surface& surface_;
    std::vector<Chart>& charts_;
    std::vector<uint32_t>& chartOfTriangle_;
    double texelMeters_;
    std::vector<uint32_t> version_;
    std::unordered_set<uint64_t> refused_;
};

} // namespace

void mergeCharts(const Surface& surface, std::vector<Chart>& charts, std::vector<uint32_t>& chartOfTriangle,
                 double texelMeters, const Progress& progress)
{
    Merging merging(surface, charts, chartOfTriangle, texelMeters);
    merging.prepare();
    for (int round = 0; round < kRounds && merging.round(progress) && !progress.cancelled(); ++round) {
    }
    merging.compact();
}

} // namespace halflight::charts
