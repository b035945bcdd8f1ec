#pragma once

#include "halflight/base/math.h"

#include <cstdint>

namespace halflight {

/// A chart patch as a light source and as a receiver.
struct PatchLight {
    static constexpr uint8_t kNoAxis = 255;
    vec3 position{0.0f};      ///< of one of its texels
    uint8_t axis = kNoAxis;   ///< that it faces, as axisOf(); kNoAxis = no texel lies in it
    bool receives = false;    ///< it is a front with texels
    float radiance = 0.0f;    ///< luminance of reflected radiance, in nits
    float illuminance = 0.0f; ///< along rays, without sampled lights, in lux
    float rays = 0.0f;        ///< that were gathered for it
};

/// A secondary light source (Keller 1997, "Instant Radiosity") has at least three times the radiosity that would give
/// its receivers the illuminance along their rays.
inline bool isSecondarySource(float radiance, float illuminance)
{
    constexpr float kBrighter = 3.0f; // ratio of radiosities: below it gather rays suffice
    const float radiosity = kPi * radiance;
    return radiosity > 0.0f && radiosity < kInfinity && radiosity >= kBrighter * illuminance;
}

} // namespace halflight
