#include "transport/guiding/receiver_grid.h"

#include "transport/guiding/patch_light.h"

#include "halflight/base/parallel.h"

#include <algorithm>
#include <functional>
#include <iterator>
#include <numeric>

namespace halflight {

std::vector<uint64_t> HashGrid::numberKeys(std::span<const uint64_t> keys, std::vector<uint32_t>& numbers)
{
    std::vector<uint64_t> sorted;
    std::copy_if(keys.begin(), keys.end(), std::back_inserter(sorted), [&](uint64_t key) { return key != kNone; });
    parallelSort(sorted, std::less<>());
    sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
    numbers.assign(keys.size(), ~0u);
    forEachIndex(keys.size(), [&](std::size_t i) {
        if (keys[i] == kNone) return;
        numbers[i] = uint32_t(std::lower_bound(sorted.begin(), sorted.end(), keys[i]) - sorted.begin());
    });
    return sorted;
}

void HitStatistics::merge(std::vector<HitStatistics>& all, std::size_t from)
{
    std::stable_sort(all.begin() + std::ptrdiff_t(from), all.end(),
                     [](const HitStatistics& a, const HitStatistics& b) { return a.cluster < b.cluster; });
    std::size_t end = from;
    for (std::size_t i = from; i < all.size(); ++i) {
        const HitStatistics s = all[i];
        if (end == from || all[end - 1].cluster != s.cluster) {
            all[end++] = s;
            continue;
        }
        all[end - 1].rays += s.rays;
        all[end - 1].light += s.light;
        all[end - 1].squares += s.squares;
    }
    all.resize(end);
}

std::vector<uint32_t> ReceiverGrid::coarsen(float width)
{
    const HashGrid wider(width);
    std::vector<uint64_t> keys;
    for (const Region& r : regions) keys.push_back(wider.key(r.position, r.axis));
    std::vector<uint32_t> parents;
    ReceiverGrid result;
    for (const uint64_t key : HashGrid::numberKeys(keys, parents)) result.regions.push_back({.key = key});
    std::vector<uint32_t> order(regions.size());
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return parents[a] < parents[b]; });
    for (std::size_t i = 0; i < order.size();) {
        const uint32_t parent = parents[order[i]];
        Region& to = result.regions[parent];
        to.position = regions[order[i]].position;
        to.axis = regions[order[i]].axis;
        to.firstHit = result.hits.size();
        for (; i < order.size() && parents[order[i]] == parent; ++i) {
            const Region& from = regions[order[i]];
            to.receivers += from.receivers;
            to.rays += from.rays;
            to.illuminances += from.illuminances;
            const auto own = hitsOf(order[i]);
            result.hits.insert(result.hits.end(), own.begin(), own.end());
        }
        HitStatistics::merge(result.hits, to.firstHit);
    }
    *this = std::move(result);
    return parents;
}

ConnectedComponents::ConnectedComponents(const ReceiverGrid& grid, std::size_t clusters) : clusters_(clusters)
{
    for (std::size_t region = 0; region < grid.regions.size(); ++region) {
        const std::span<const HitStatistics> hits = grid.hitsOf(region);
        for (const HitStatistics& h : hits) clusters_.join(h.cluster, hits.front().cluster);
        clusterOfRegion_.push_back(hits.empty() ? ~0u : hits.front().cluster);
    }
}

Observations::Observations(const ReceiverGrid& grid, uint32_t region, float illuminanceBeside)
{
    float receivers = 0.0f;
    float illuminances = 0.0f;
    HashGrid::around(grid.regions[region].key, [&](uint64_t key) {
        const auto found = std::lower_bound(grid.regions.begin(), grid.regions.end(), key,
                                            [](const ReceiverGrid::Region& r, uint64_t k) { return r.key < k; });
        if (found == grid.regions.end() || found->key != key) return;
        const auto other = std::size_t(found - grid.regions.begin());
        rays += found->rays;
        receivers += found->receivers;
        illuminances += found->illuminances;
        for (const HitStatistics& h : grid.hitsOf(other)) {
            if (!isSecondarySource(h.light / h.rays, illuminanceBeside)) continue;
            hits.push_back(h);
            hitCount += h.rays;
        }
    });
    HitStatistics::merge(hits);
    illuminance = grid.regions[region].illuminance();
    if (!(illuminance > 0.0f)) illuminance = illuminances / std::max(receivers, 1.0f);
}

} // namespace halflight
