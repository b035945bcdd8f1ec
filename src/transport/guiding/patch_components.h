#pragma once
// Light of patches by component, for guides that serve each component.

#include "transport/guiding/patch_light.h"
#include "transport/radiosity/build.h"
#include "transport/radiosity/factor_rows.h"

#include <span>
#include <vector>

namespace halflight {

/// Observations of patches by receivers, from the samples of the radiosity stage.
class PatchObservations {
public:
    explicit PatchObservations(const Radiosity& radiosity)
        : solution_(radiosity.solution), chartPatches_(radiosity.solution.cache.layout().chartPatches),
          rows_(solution_.factors, chartPatches_,
                [&](PatchId unknown) { return std::size_t(unknown != kNoPatch ? patchOf(unknown) : kNoPatch); })
    {}
    [[nodiscard]] PatchId frontPatches() const { return chartPatches_; }
    /// Calls body(samples, links) for samples of a front patch. Links are unknowns.
    template<typename Body> void forSamples(PatchId front, const Body& body) const
    {
        for (const FactorRows::Term& term : rows_.of(front)) {
            if (term.isLate()) continue;
            const FormFactorRange& range = solution_.factors[term.range];
            body(range.samples[term.index], std::span(range.links).subspan(term.firstLink, term.linkCount));
        }
    }
    /// Calls body(patch) for each ray from a front patch to a chart patch.
    template<typename Body> void forRays(PatchId front, const Body& body) const
    {
        forSamples(front, [&](const PatchSamples&, std::span<const PatchId> links) {
            for (const PatchId target : links) {
                if (target != kNoPatch && patchOf(target) < 2 * chartPatches_) body(patchOf(target));
            }
        });
    }
    [[nodiscard]] PatchId patchOf(uint32_t unknown) const { return solution_.patchOfUnknown[unknown]; }

private:
    const RadiositySolution& solution_;
    uint32_t chartPatches_;
    FactorRows rows_; ///< by front patch
};

/// Light of patches by component. A patch is a source where it is one beside the illuminance of some component.
struct PatchComponents {
    std::size_t count = 0;          ///< 0 = light is estimated as one
    std::vector<float> radiance;    ///< nits, by patch and component
    std::vector<float> illuminance; ///< lux, by front chart patch and component

    [[nodiscard]] std::span<const float> radianceOf(PatchId patch) const
    {
        return std::span(radiance).subspan(patch * count, count);
    }
};

/// Sets the light of patches to the sum over components of their light over its mean, so that samples within a cluster
/// serve all. Nothing where light is estimated as one.
PatchComponents findComponents(const Radiosity& radiosity, const PatchObservations& observations,
                               std::vector<PatchLight>& lights);

} // namespace halflight
