#pragma once
// Where light probes go (spec S14), and the links between neighbours along which they are refined and denoised.

#include "halflight/bake/integrator.h"
#include "halflight/scene/baked_scene.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace halflight {

/// Difference of occlusion (0…1), or of irradiance over the larger of both, from which on two probes, or a probe and
/// its interpolation, disagree.
constexpr float kDisagrees = 0.35f;

/// Most probes of a bake, unless a spacing is asked for: with tetrahedra and maps of what they see about 12 MB.
constexpr std::size_t kMostProbes = 20000;
/// Paths of a test point: enough to find those inside geometry.
constexpr int kTestPaths = 8;

/// Two neighbouring probes, by index.
struct ProbeLink {
    uint32_t a = 0;
    uint32_t b = 0;
    float spacing = 0.0f; ///< shortest side of the cell that it was an edge of, metres
};

/// Probes of a bake stand on a lattice that floats hold exactly, so that tetrahedra between them are exact in a file
/// too. Its step, metres: a power of two, about a millionth (2^-20) of the box. 0 where that has no extent.
float probeStep(vec3 boxSize);
/// The lattice point nearest to a position. `step`: probeStep().
vec3 onProbeLattice(vec3 position, float step);

/// Probes to add. The first gets the index after the last existing probe.
struct AddedProbes {
    std::vector<vec3> positions;  ///< world space, metres
    std::vector<vec3> sides;      ///< by position: of the cell that it was placed by, metres
    std::vector<ProbeLink> links; ///< between added and existing probes

    void add(vec3 position, vec3 cellSides)
    {
        positions.push_back(position);
        sides.push_back(cellSides);
    }
};

inline float shortestSide(vec3 sides)
{
    return std::min({sides.x, sides.y, sides.z});
}

/// Irradiance (lux) from which on differences count: a small share of the median probe's. Nothing where no probe is
/// valid.
std::optional<float> darkIrradiance(std::span<const Probe> probes);
/// Irradiance (luminance, lux) on the six faces of a small cube.
std::array<float, 6> irradianceAround(const SphericalHarmonicsL2& radiance);
/// 1 or more where some of the probes need others in between. `dark`: darkIrradiance().
float disagreement(std::span<const Probe* const> probes, float dark);

/// One level of refinement: a probe in the middle of each unoccluded link whose ends disagree, and probes on both sides
/// of the surfaces on each occluded one. The total stays below `most` probes; the largest disagreements come first.
/// `sides`: by probe, of the cell that it was placed by.
Result<AddedProbes> probesBetween(std::span<const Probe> probes, std::span<const vec3> sides,
                                  std::span<const ProbeLink> links, std::size_t most, const Integrator& integrator);

/// A layer of up to `most` probes just above the floors. Objects stand on floors: without the layer, points below the
/// lowest probes lie in tetrahedra that reach through the floor, or beyond its rim. Walls and ceilings have no such
/// layer. `sides`: as above; the vertical one is the largest distance to the floor below a probe.
Result<AddedProbes> probesOnFloors(std::span<const Probe> probes, std::span<const vec3> sides, std::size_t most,
                                   const Integrator& integrator);

/// Probes closer than this share of the shortest spacing are one.
constexpr float kSamePlaceShare = 0.05f;

/// Bilateral filter of SH coefficients (Tomasi and Manduchi 1998) over mutually visible linked probes. One weight
/// serves all nine coefficients, so that directions and the ratio of bands stay. `variances`: of the luminance of a
/// coefficient.
Status denoiseProbes(std::span<Probe> probes, std::vector<float> variances, std::span<const ProbeLink> links,
                     const Integrator& integrator);

} // namespace halflight
