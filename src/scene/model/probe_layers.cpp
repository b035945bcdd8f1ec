// Probes in a plane, on a line or at one place, given an extent along every axis.
#include "halflight/scene/probe_cells.h"

namespace halflight {

bool addProbeLayers(ProbeSet& set)
{
    const ProbeCells cells = probeCells(set);
    if (!glm::any(cells.flat)) return false;
    std::vector<uint32_t> probeOf(cells.probeOf.begin(), cells.probeOf.begin() + std::ptrdiff_t(cells.probeCount));
    for (std::size_t v = cells.probeCount; v < cells.vertices.size(); ++v) {
        Probe copy = set.probes[cells.probeOf[v]];
        copy.position = vec3(cells.origin + cells.frame * cells.vertices[v]);
        probeOf.push_back(uint32_t(set.probes.size()));
        set.probes.push_back(copy);
    }
    set.tetrahedra = cells.cells;
    for (Tetrahedron& cell : set.tetrahedra) {
        for (uint32_t& vertex : cell.vertex) vertex = probeOf[vertex];
    }
    set.origin = vec3(0.0f);
    set.spacingMeters = vec3(1.0f);
    set.size = ivec3(0);
    return true;
}

} // namespace halflight
