#pragma once
// Where light probes go (spec S14), and the links between neighbours along which they are refined and denoised.

#include "halflight/bake/integrator.h"
#include "halflight/scene/baked_scene.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace halflight {

/// Two neighbouring probes, by index.
struct ProbeLink {
    uint32_t a = 0;
    uint32_t b = 0;
};

/// Links along the axes of a grid of probes, in the order of ProbeSet::probes.
std::vector<ProbeLink> linksOfGrid(ivec3 size);

/// Probes to add. The first gets the index after the last existing probe.
struct AddedProbes {
    std::vector<vec3> positions;  ///< world space, metres
    std::vector<ProbeLink> links; ///< between added and existing probes
};

/// One level of refinement: a probe in the middle of each unoccluded link whose ends disagree, and probes on both sides
/// of the surfaces on each occluded one. `spacing`: shortest side of the grid's cells, metres. The total stays below
/// `most` probes; the largest disagreements come first.
AddedProbes probesBetween(std::span<const Probe> probes, std::span<const ProbeLink> links, float spacing,
                          std::size_t most, const Integrator& integrator);

/// A layer of probes just above the floors. Objects stand on floors: without the layer, points below the lowest probes
/// lie in tetrahedra that reach through the floor, or beyond its rim. Walls and ceilings have no such layer.
/// `reachMeters`: largest distance to the floor below a probe.
AddedProbes probesOnFloors(std::span<const Probe> probes, float spacing, float reachMeters,
                           const Integrator& integrator);

/// Probes closer than this share of the spacing are one.
constexpr float kSamePlaceShare = 0.05f;

/// Bilateral filter of SH coefficients (Tomasi and Manduchi 1998) over mutually visible linked probes. One weight
/// serves all nine coefficients, so that directions and the ratio of bands stay. `variances`: of the luminance of a
/// coefficient.
void denoiseProbes(std::span<Probe> probes, std::span<const float> variances, std::span<const ProbeLink> links,
                   const Integrator& integrator);

} // namespace halflight
