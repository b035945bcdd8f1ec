#pragma once
// Values by lane, in arrays: compilers turn loops over them into vector instructions.

#include "halflight/base/math.h"

#include <array>
#include <cstddef>

namespace halflight {

/// Texels, receivers or rays that are worked on together: as many as a packet of rays has.
inline constexpr int kLanes = 8;

/// Vectors as three arrays.
struct alignas(32) Vec3Lanes {
    std::array<float, kLanes> x;
    std::array<float, kLanes> y;
    std::array<float, kLanes> z;

    void set(std::size_t lane, vec3 v)
    {
        x[lane] = v.x;
        y[lane] = v.y;
        z[lane] = v.z;
    }
    [[nodiscard]] vec3 operator[](std::size_t lane) const { return {x[lane], y[lane], z[lane]}; }
};

struct alignas(32) Vec2Lanes {
    std::array<float, kLanes> x;
    std::array<float, kLanes> y;

    void set(std::size_t lane, vec2 v)
    {
        x[lane] = v.x;
        y[lane] = v.y;
    }
};

} // namespace halflight
