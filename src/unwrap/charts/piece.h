#pragma once
// A set of triangles on its way to being a chart: what flattening works on.

#include "unwrap/surface/surface.h"

#include <algorithm>

namespace halflight::charts {

/// Where a triangle is among ascending ones; kNone where it is not.
inline uint32_t placeAmong(const std::vector<uint32_t>& triangles, uint32_t triangle)
{
    const auto found = std::lower_bound(triangles.begin(), triangles.end(), triangle);
    return found != triangles.end() && *found == triangle ? uint32_t(found - triangles.begin()) : kNone;
}

/// Working copy of the chart: corners joined into vertices over the chart's own inner edges, so that sheets which only
/// touch in a point stay apart.
struct Piece {
    const Surface& surface;
    std::vector<uint32_t> triangles;
    std::vector<uint32_t> corners;
    std::vector<dvec3> positions;
    std::vector<char> onBorder; ///< by vertex
    dvec3 meanNormal{0.0};
    double area = 0.0;
    double perimeter = 0.0;
    double leastCosine = 1.0; ///< between a normal and the mean normal

    Piece(const Surface& s, std::vector<uint32_t> t);

private:
    void joinCorners();
};

struct Basis {
    dvec3 x, y;
};

/// Two unit vectors that make a right-handed frame with `n` (Duff et al. 2017, "Building an Orthonormal Basis,
/// Revisited").
Basis basisOf(dvec3 n);

/// Seen from the mean normal.
std::vector<dvec2> project(const Piece& piece);

/// Twice the area of triangle `t` of the piece where `uv` lays it; negative where it is turned over.
double doubleAreaOf(const Piece& piece, const std::vector<dvec2>& uv, std::size_t t);

} // namespace halflight::charts
