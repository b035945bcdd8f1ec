#pragma once
// Where the surfaces of a scene cross one another, and the planes along which meshes are cut for it.

#include "halflight/unwrap/unwrap.h"
#include "unwrap/cuts/cut_mesh.h"

namespace halflight::charts {

/// A surface that may be cut: that of one object.
struct CutCandidate {
    int object = -1;
    const Surface* surface = nullptr; ///< of its mesh
    std::span<const uint32_t> pieces; ///< smoothPieces()
    double texelMeters = 0.0;         ///< width of its texels to come
    std::vector<PlaneCut> cuts;       ///< the result
};

/// By mesh, 1 where copies of it for each of its objects would take little memory.
std::vector<uint8_t> copyableMeshes(const Scene& scene);

/// Finds the cuts of all candidates. `totalTexels`: about as many as the scene will have; cuts add at most a few per
/// cent to that. A warning says how many crossings stay uncut therefore.
void findCuts(const Scene& scene, std::vector<CutCandidate>& candidates, double totalTexels, const CrossingTest& test,
              std::vector<std::string>& warnings);

} // namespace halflight::charts
