#include "unwrap/charts/piece.h"

#include "halflight/base/disjoint_sets.h"

#include <cmath>

namespace halflight::charts {

Piece::Piece(const Surface& s, std::vector<uint32_t> t) : surface(s), triangles(std::move(t))
{
    joinCorners();
    for (const uint32_t triangle : triangles) {
        meanNormal += surface.areas[triangle] * surface.normals[triangle];
        area += surface.areas[triangle];
    }
    const double length = glm::length(meanNormal);
    meanNormal = length > 1e-9 * area ? meanNormal / length : surface.normals[triangles[0]];
    for (const uint32_t triangle : triangles)
        leastCosine = std::min(leastCosine, glm::dot(meanNormal, surface.normals[triangle]));
}

void Piece::joinCorners()
{
    DisjointSets joined(3 * triangles.size()); // corners at one place
    std::vector<char> borderCorner(joined.size(), 0);
    for (uint32_t i = 0; i < triangles.size(); ++i) {
        for (uint32_t k = 0; k < 3; ++k) {
            const uint32_t half = surface.neighbors[3 * triangles[i] + k];
            const uint32_t j = half == kNone ? kNone : placeAmong(triangles, half / 3);
            if (j == kNone) {
                borderCorner[3 * i + k] = borderCorner[3 * i + (k + 1) % 3] = 1;
                perimeter +=
                    glm::distance(surface.corner(triangles[i], int(k)), surface.corner(triangles[i], int((k + 1) % 3)));
            } else if (i < j) {
                joined.join(3 * i + k, 3 * j + (half % 3 + 1) % 3);
                joined.join(3 * i + (k + 1) % 3, 3 * j + half % 3);
            }
        }
    }
    corners.assign(joined.size(), kNone);
    for (uint32_t c = 0; c < joined.size(); ++c) {
        const uint32_t root = joined.find(c);
        if (corners[root] == kNone) {
            corners[root] = uint32_t(positions.size());
            positions.push_back(surface.corner(triangles[root / 3], int(root % 3)));
            onBorder.push_back(0);
        }
        corners[c] = corners[root];
        if (borderCorner[c]) onBorder[corners[c]] = 1;
    }
}

Basis basisOf(dvec3 n)
{
    const double sign = std::copysign(1.0, n.z);
    const double a = -1.0 / (sign + n.z), b = n.x * n.y * a;
    return {{1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}};
}

std::vector<dvec2> project(const Piece& piece)
{
    const Basis basis = basisOf(piece.meanNormal);
    const dvec3 origin = piece.positions[0];
    std::vector<dvec2> uv(piece.positions.size());
    for (std::size_t v = 0; v < uv.size(); ++v) {
        const dvec3 p = piece.positions[v] - origin;
        uv[v] = {glm::dot(p, basis.x), glm::dot(p, basis.y)};
    }
    return uv;
}

double doubleAreaOf(const Piece& piece, const std::vector<dvec2>& uv, std::size_t t)
{
    const dvec2 a = uv[piece.corners[3 * t]], b = uv[piece.corners[3 * t + 1]], c = uv[piece.corners[3 * t + 2]];
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

} // namespace halflight::charts
