#pragma once
// Keys of a hash grid: world space in cubes of one size.

#include "halflight/base/math.h"

#include <cstdint>
#include <unordered_set>

namespace halflight {

/// The grid cell of a point. Points farther than 10⁶ cells from the origin share the outermost cells.
inline ivec3 gridCell(vec3 point, float cellMeters)
{
    return ivec3(glm::floor(glm::clamp(point / cellMeters, -1.0e6f, 1.0e6f)));
}

/// 21 bits of each coordinate: unique for all cells of gridCell().
inline uint64_t gridKey(ivec3 cell)
{
    const auto part = [](int v) { return uint64_t(uint32_t(v)) & 0x1fffffu; };
    return part(cell.x) | (part(cell.y) << 21) | (part(cell.z) << 42);
}

/// Points of which each lies in a grid cell of its own.
class DistinctPoints {
public:
    explicit DistinctPoints(float cellMeters) : cellMeters_(cellMeters) {}
    /// False if a point in the same cell is in the set already.
    bool insert(vec3 point) { return cells_.insert(gridKey(gridCell(point, cellMeters_))).second; }

private:
    float cellMeters_;
    std::unordered_set<uint64_t> cells_;
};

} // namespace halflight
