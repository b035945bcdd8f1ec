#pragma once
// Receivers by region of space, with statistics of the secondary sources that their rays hit.

#include "halflight/base/disjoint_sets.h"
#include "halflight/base/math.h"

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace halflight {

/// Hash grid of receivers: cells of space, with one key for each of the six axes that surfaces in the cell face. It has
/// the role of the tree of Müller, Gross and Novák 2017, "Practical Path Guiding for Efficient Light-Transport
/// Simulation".
class HashGrid {
public:
    static constexpr uint64_t kNone = ~uint64_t(0);

    explicit HashGrid(float width) : width_(width) {}
    [[nodiscard]] uint64_t key(vec3 position, int axis) const
    {
        return pack(ivec3(glm::floor(position / width_)), axis);
    }
    /// Calls body(key) for a cell and its 26 neighbours.
    template<typename Body> static void around(uint64_t key, const Body& body)
    {
        const ivec3 at(int(key >> 40 & kMask), int(key >> 20 & kMask), int(key & kMask));
        for (int i = 0; i < 27; ++i) body(pack(at + ivec3(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1), int(key >> 60)));
    }
    /// Numbers all keys but kNone in ascending order. `numbers` gets the number of each, or ~0. Returns the keys by
    /// number.
    static std::vector<uint64_t> numberKeys(std::span<const uint64_t> keys, std::vector<uint32_t>& numbers);

private:
    static constexpr uint64_t kMask = (1u << 20) - 1u;
    static uint64_t pack(ivec3 at, int axis)
    {
        return uint64_t(axis) << 60 | (uint64_t(at.x) & kMask) << 40 | (uint64_t(at.y) & kMask) << 20 |
               (uint64_t(at.z) & kMask);
    }
    float width_;
};

/// Rays that hit a light cluster: their number, and sums of luminance and of its square.
struct HitStatistics {
    uint32_t cluster = 0;
    float rays = 0.0f;
    float light = 0.0f;
    float squares = 0.0f;

    /// Adds up the statistics of each cluster from an index on, and sorts them by cluster.
    static void merge(std::vector<HitStatistics>& all, std::size_t from = 0);
};

/// Receiver regions of one width, by hash grid cell.
struct ReceiverGrid {
    struct Region {
        uint64_t key = 0;
        vec3 position{0.0f}; ///< of one receiver
        int axis = 0;
        float receivers = 0.0f;
        float rays = 0.0f;
        float illuminances = 0.0f; ///< sum over the receivers
        std::size_t firstHit = 0;

        [[nodiscard]] float illuminance() const { return illuminances / std::max(receivers, 1.0f); }
    };
    std::vector<Region> regions;     ///< in ascending order of keys
    std::vector<HitStatistics> hits; ///< region by region, by cluster

    [[nodiscard]] std::span<const HitStatistics> hitsOf(std::size_t region) const
    {
        const std::size_t end = region + 1 < regions.size() ? regions[region + 1].firstHit : hits.size();
        return std::span(hits).subspan(regions[region].firstHit, end - regions[region].firstHit);
    }
    /// Replaces the regions by wider ones. Returns the new region of each old one.
    std::vector<uint32_t> coarsen(float width);
};

/// Connected components of the graph between clusters and the regions whose rays hit them. Rooms without a line of
/// sight between them are different components.
class ConnectedComponents {
public:
    ConnectedComponents(const ReceiverGrid& grid, std::size_t clusters);
    [[nodiscard]] uint32_t ofCluster(uint32_t cluster) { return clusters_.find(cluster); }
    /// ~0 for regions without hits.
    [[nodiscard]] uint32_t ofRegion(uint32_t region)
    {
        return clusterOfRegion_[region] != ~0u ? clusters_.find(clusterOfRegion_[region]) : ~0u;
    }

private:
    DisjointSets clusters_;
    std::vector<uint32_t> clusterOfRegion_; ///< one that its rays hit, or ~0
};

/// Hits of a region and its 26 neighbours on sources that are secondary beside an illuminance.
struct Observations {
    std::vector<HitStatistics> hits; ///< by cluster; neighbours count half
    float rays = 0.0f;
    float hitCount = 0.0f;
    float illuminance = 0.0f; ///< of the region; if 0, of the region and its neighbours

    Observations(const ReceiverGrid& grid, uint32_t region, float illuminanceBeside);
    /// Keeps at most `most` clusters, those of highest rank.
    template<typename Rank> void keepHighest(std::size_t most, const Rank& rank)
    {
        if (hits.size() <= most) return;
        std::stable_sort(hits.begin(), hits.end(),
                         [&](const HitStatistics& a, const HitStatistics& b) { return rank(a) > rank(b); });
        hits.resize(most);
        std::sort(hits.begin(), hits.end(),
                  [](const HitStatistics& a, const HitStatistics& b) { return a.cluster < b.cluster; });
    }
    /// Mean square of a ray's contribution over the square of an illuminance, from a sum of squares of luminance.
    [[nodiscard]] float relativeVariance(double squares, float illuminance) const
    {
        const double perIlluminance = double(kPi) / double(illuminance);
        return float(perIlluminance * perIlluminance * squares / double(rays));
    }
};

} // namespace halflight
