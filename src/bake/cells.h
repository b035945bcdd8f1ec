#pragma once
// Cells of a hash grid in the world.

#include "halflight/base/math.h"

#include <cstdint>

namespace halflight {

/// The cell that a point is in.
inline ivec3 cellOf(vec3 point, float cellMeters)
{
    return ivec3(glm::floor(glm::clamp(point / cellMeters, -1.0e6f, 1.0e6f)));
}

/// 21 bits of each coordinate: no two cells that cellOf() gives have the same.
inline uint64_t cellKey(ivec3 cell)
{
    const auto part = [](int v) { return uint64_t(uint32_t(v)) & 0x1fffffu; };
    return part(cell.x) | (part(cell.y) << 21) | (part(cell.z) << 42);
}

} // namespace halflight
