#pragma once
// Guides: for each receiver a discrete distribution over light clusters.

#include "transport/guiding/source_clusters.h"

#include <span>
#include <vector>

namespace halflight {

/// Entries of one distribution.
struct GuideList {
    uint32_t first = 0;
    uint32_t count = 0;
};

/// Distribution over clusters for the receivers of one region.
struct Guide {
    GuideList local;               ///< clusters that rays of the region and its neighbours hit
    GuideList shared;              ///< clusters that rays of a wider region hit
    float relativeVariance = 0.0f; ///< of a gather ray due to these clusters: mean square / illuminance^2

    /// Share of samples of the shared list: lists with entries have the same.
    [[nodiscard]] float sharedFraction() const { return shared.count == 0 ? 0.0f : local.count == 0 ? 1.0f : 0.5f; }
};

/// Small bright sources cause most of the variance of a gather, because few rays hit them. The gather samples them by
/// area too, with MIS against its rays (Veach and Guibas 1995). Which clusters a receiver samples follows from the rays
/// of the radiosity stage (path guiding: Jensen 1995, "Importance Driven Path Tracing using the Photon Map"; Vorba et
/// al. 2014, "On-line Learning of Parametric Mixture Models for Light Transport Simulation"). Sources that no guide has
/// are left to the rays.
class Guides {
public:
    Guides() = default;

    template<typename Archive> void archive(Archive& a)
    {
        clusters_.archive(a);
        a(guideOfPatch_, guides_, entries_, cumulative_);
    }
    /// Whether no source is sampled.
    [[nodiscard]] bool empty() const { return clusters_.empty(); }
    [[nodiscard]] const SourceClusters& clusters() const { return clusters_; }
    /// Guide at a point of a front; without sources where there is none.
    [[nodiscard]] Guide guideAt(const PatchLayout& layout, const SurfacePoint& point) const;

    /// A cluster of a list, with the probability that it is chosen.
    struct Entry {
        uint32_t cluster = 0;
        float probability = 0.0f;
    };
    [[nodiscard]] std::span<const Guide> guides() const { return guides_; }
    /// By patch, the first ones; ~0 = none.
    [[nodiscard]] std::span<const uint32_t> guideOfPatch() const { return guideOfPatch_; }
    /// List by list, in ascending order of clusters; and the probability of a list's entries up to each.
    [[nodiscard]] std::span<const Entry> entries() const { return entries_; }
    [[nodiscard]] std::span<const float> cumulative() const { return cumulative_; }

    /// A point of one of the guide's clusters; none where the guide has no clusters.
    [[nodiscard]] SourcePoint choosePoint(const Guide& guide, vec2 u) const;
    /// Density of the guide's samples on a chart patch, per square metre; 0 for patches that are not sampled.
    [[nodiscard]] float pdfArea(const Guide& guide, PatchId patch) const
    {
        return probability(guide, clusters_.clusterOf(patch)) * clusters_.pdfArea(patch);
    }

private:
    friend class GuideBuilder;
    [[nodiscard]] float probability(const Guide& guide, uint32_t cluster) const;
    [[nodiscard]] float probability(const GuideList& list, uint32_t cluster) const;

    SourceClusters clusters_;
    std::vector<uint32_t> guideOfPatch_; ///< ~0 = none
    std::vector<Guide> guides_;
    std::vector<Entry> entries_;
    std::vector<float> cumulative_;
};

} // namespace halflight
