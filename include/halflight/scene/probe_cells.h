#pragma once
// The tetrahedra between the valid probes of a bake, which baked files hold and in which probe light is interpolated.

#include "halflight/scene/baked_scene.h"

#include <glm/gtc/type_precision.hpp>

#include <cstdint>
#include <vector>

namespace halflight {

/// Tetrahedra in a space of their own: p = transpose(frame) * (world - origin), metres.
struct ProbeCells {
    glm::dvec3 origin{0.0};
    glm::dmat3 frame{1.0};
    glm::bvec3 flat{false}; ///< axes along which probes do not differ: points are taken to 0 there
    std::vector<glm::dvec3> vertices;
    std::vector<uint32_t> probeOf; ///< vertex -> index into ProbeSet::probes
    std::vector<Tetrahedron> cells;
    std::size_t probeCount = 0;    ///< valid probes in use; vertices after these are copies along flat axes
    vec3 spacingMeters{kInfinity}; ///< mean distance of neighbours along each axis of the world
};

/// Tetrahedra of all valid probes; no vertices without any. Those of the set are taken where it has some that fit.
ProbeCells probeCells(const ProbeSet& set);

/// Where the valid probes lie in a plane, on a line or at one place: adds copies of them one layer up, with the same
/// light, and the tetrahedra of both. Such a set is no grid any more. Call it before ProbeSight is made. Returns
/// whether it added any.
bool addProbeLayers(ProbeSet& set);

/// The cells as a file holds them: vertices are indices into ProbeSet::probes. Empty where the probes lie in one plane,
/// as they do only in files that were baked before addProbeLayers().
std::vector<Tetrahedron> fileTetrahedra(const ProbeCells& cells);

} // namespace halflight
