#pragma once
// Validity of the sample points of many texels at once, on a device.

#include "halflight/bake/integrator.h"
#include "halflight/base/result.h"

#include <array>
#include <cstdint>
#include <span>

namespace halflight {

/// Tests all points of texels, as TexelValidity::validPoints() does.
class DeviceValidity {
public:
    virtual ~DeviceValidity() = default;

    struct Point {
        vec3 origin{0.0f}; ///< of rays
        vec3 normal{0.0f};
        vec3 geometricNormal{0.0f};
    };
    struct Texel {
        uint32_t id = 0;         ///< texelId()
        uint32_t pointCount = 0; ///< 1 … kMaxTexelPoints
        std::array<Point, kMaxTexelPoints> points;
    };

    /// Masks of any number of texels. `rays` are counted.
    virtual Status validPoints(std::span<const Texel> texels, std::span<PointMask> masks, uint64_t& rays) const = 0;
};

} // namespace halflight
