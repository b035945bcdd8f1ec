#pragma once
// Radiance of the patches that a block's rays hit.

#include "transport/lightmap/block_sums.h"
#include "transport/radiosity/radiance_cache.h"

namespace halflight {

class HitLookup {
public:
    /// `cache` null = no hit has a patch.
    explicit HitLookup(const RadianceCache* cache) : cache_(cache) {}

    /// Looks up the hits of all rays of a bundle.
    void lookUp(const RayBundle& bundle)
    {
        for (int stratum = 0; stratum < StratifiedPattern::kBlock; ++stratum) {
            for (int lane = 0; lane < kLanes; ++lane) {
                const RayHit& at = bundle.hit(stratum, lane);
                Hit& hit = hits_[sampleOf(stratum, lane)];
                hit = {};
                hit.found = at.found();
                if (!hit.found || cache_ == nullptr || !cache_->layout().hasPatches(at.face)) continue;
                hit.emissive = cache_->layout().emissive(at.face);
                hit.patch = cache_->layout().patchAt(at.face, at.barycentric);
                hit.radiance = cache_->find({at.face, at.barycentric, {}, at.distance}, hit.patch);
            }
        }
    }

    [[nodiscard]] bool missed(std::size_t sample) const { return !hits_[sample].found; }
    [[nodiscard]] bool emissive(std::size_t sample) const { return hits_[sample].emissive; }
    /// The patch that a ray hits, or kNoPatch; its elements have their own radiance.
    [[nodiscard]] PatchId patch(std::size_t sample) const { return hits_[sample].patch; }
    /// Radiance at the end of a ray; null if the cache has none.
    [[nodiscard]] const PatchRadiance* radiance(std::size_t sample) const { return hits_[sample].radiance; }

private:
    struct Hit {
        const PatchRadiance* radiance = nullptr;
        PatchId patch = kNoPatch;
        bool found = false;
        bool emissive = false;
    };
    const RadianceCache* cache_;
    std::array<Hit, kBlockSamples> hits_;
};

} // namespace halflight
