#pragma once
// Delaunay tetrahedra of points on an integer lattice, exact.

#include "halflight/base/math.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace halflight {

/// Coordinates of lattice points lie in [0, 2^kLatticeBits].
constexpr int kLatticeBits = 22;
/// In place of a neighbour: beyond this face lies the outside.
constexpr uint32_t kOutside = 0xffffffffu;

struct Tetrahedron {
    /// Positively oriented: dot(v1 - v0, cross(v2 - v0, v3 - v0)) > 0.
    std::array<uint32_t, 4> vertex{};
    /// neighbor[i] lies beyond the face opposite vertex[i].
    std::array<uint32_t, 4> neighbor{};
};

/// The Delaunay tetrahedra of distinct points: they fill the convex hull, meet face to face, and none is flat. The
/// result is a function of the points and their order alone: where five or more points lie on one sphere, the choice
/// falls as if each point were lowered a little, the later the more, on the paraboloid of the lifting map; so the cells
/// of a regular grid in row order all fall into the same six tetrahedra. Empty when all points lie in one plane.
std::vector<Tetrahedron> tetrahedralize(std::span<const ivec3> points);

} // namespace halflight
