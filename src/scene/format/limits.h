#pragma once
// What numbers a scene may hold, so that no sum of a bake leaves the floats.

#include "halflight/base/result.h"
#include "halflight/scene/baked_scene.h"

namespace halflight {

/// Radiance (cd/m2), intensity (cd) or illuminance (lux) of one source may be this much: 600 times the sun's disc.
/// Bakes and denoisers sum squares of radiance over up to 1e13 samples, and a float ends at 3.4e38.
constexpr float kBrightest = 1.0e12f;

/// Emission of materials, light of lights (times its indirect multiplier), sky and shadow colour within kBrightest.
Status checkBrightness(const Scene& scene);

/// Whether all that a bake adds is within its ranges (bake_ranges.h), and probes are where their grid says.
Status checkBakedValues(const BakedScene& baked);

} // namespace halflight
