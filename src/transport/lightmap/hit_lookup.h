#pragma once
// Radiance of the patches that a block's rays hit.

#include "transport/lightmap/block_sums.h"
#include "transport/radiosity/radiance_cache.h"
#include "transport/trace/prefetch.h"

namespace halflight {

/// Looks up many hits in sweeps: each sweep prefetches the memory that the next one reads.
class HitLookup {
public:
    /// `cache` null = no hit has a patch.
    explicit HitLookup(const RadianceCache* cache) : cache_(cache) {}

    /// Looks up the hits of all rays of a bundle.
    void lookUp(const RayBundle& bundle);

    [[nodiscard]] bool missed(std::size_t sample) const { return !hits_[sample].found; }
    [[nodiscard]] bool emissive(std::size_t sample) const { return hits_[sample].emissive; }
    /// The patch that a ray hits, or kNoPatch; its elements have their own radiance.
    [[nodiscard]] PatchId patch(std::size_t sample) const { return hits_[sample].patch; }
    /// Radiance at the end of a ray; null if the cache has none.
    [[nodiscard]] const PatchRadiance* radiance(std::size_t sample) const
    {
        return cached_[sample] != kNoPatch ? &cache_->patches()[cached_[sample]] : nullptr;
    }

    /// First step for points that no bundle has: sets the patch of a sample.
    void setPatch(std::size_t sample, FaceId face, PatchId patch)
    {
        cached_[sample] = patch;
        prefetch(cache_->patches() + patch);
        prefetch(&cache_->layout().surface(face));
    }
    struct FacePoint {
        FaceId face;
        vec2 barycentric{0.0f};
    };
    /// Second step, RadianceCache::find() for samples whose patches are set: radiance() is that of the patch or element
    /// over distanceOf(sample). pointOf(sample) is called for elements.
    template<typename DistanceOf, typename PointOf>
    void find(std::span<const uint8_t> samples, const DistanceOf& distanceOf, const PointOf& pointOf);

private:
    struct Hit {
        PatchId patch = kNoPatch;
        bool found = false;
        bool emissive = false;
    };
    const RadianceCache* cache_;
    std::array<Hit, kBlockSamples> hits_;
    std::array<PatchId, kBlockSamples> cached_; ///< patch or element whose radiance is usable, or kNoPatch
};

inline void HitLookup::lookUp(const RayBundle& bundle)
{
    for (int stratum = 0; stratum < StratifiedPattern::kBlock; ++stratum) {
        for (int lane = 0; lane < TexelGroup::kLanes; ++lane) {
            const std::size_t sample = sampleOf(stratum, lane);
            const RayHit& hit = bundle.hit(stratum, lane);
            hits_[sample] = {kNoPatch, hit.found(), false};
            cached_[sample] = kNoPatch;
            if (hit.found() && cache_ != nullptr) prefetch(&cache_->layout().surface(hit.face));
        }
    }
    if (cache_ == nullptr) return;
    const PatchLayout& layout = cache_->layout();
    SampleList onPatches;
    for (int stratum = 0; stratum < StratifiedPattern::kBlock; ++stratum) {
        for (int lane = 0; lane < TexelGroup::kLanes; ++lane) {
            const std::size_t sample = sampleOf(stratum, lane);
            Hit& hit = hits_[sample];
            if (!hit.found) continue;
            const RayHit& at = bundle.hit(stratum, lane);
            if (!layout.hasPatches(at.face)) continue;
            hit.emissive = layout.emissive(at.face);
            hit.patch = layout.patchAt(at.face, at.barycentric);
            prefetch(cache_->patches() + hit.patch);
            cached_[sample] = hit.patch;
            onPatches.add(sample);
        }
    }
    find(
        onPatches.samples(),
        [&](std::size_t sample) { return bundle.hit(int(stratumOf(sample)), laneOf(sample)).distance; },
        [&](std::size_t sample) {
            const RayHit& at = bundle.hit(int(stratumOf(sample)), laneOf(sample));
            return FacePoint{at.face, at.barycentric};
        });
}

template<typename DistanceOf, typename PointOf>
void HitLookup::find(std::span<const uint8_t> samples, const DistanceOf& distanceOf, const PointOf& pointOf)
{
    if (samples.empty()) return;
    const PatchRadiance* patches = cache_->patches();
    SampleList inElements;
    for (const std::size_t sample : samples) {
        if (patches[cached_[sample]].usableAt(distanceOf(sample))) continue;
        inElements.add(sample);
        cache_->layout().prefetchElements(cached_[sample]);
    }
    for (const std::size_t sample : inElements.samples()) {
        const FacePoint point = pointOf(sample);
        cached_[sample] = cache_->layout().elementAt(point.face, point.barycentric, cached_[sample]);
        if (cached_[sample] != kNoPatch) prefetch(patches + cached_[sample]);
    }
    for (const std::size_t sample : inElements.samples()) {
        PatchId& element = cached_[sample];
        if (element != kNoPatch && !patches[element].usableAt(distanceOf(sample))) element = kNoPatch;
    }
}

} // namespace halflight
