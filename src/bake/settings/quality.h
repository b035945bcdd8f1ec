#pragma once
// The numbers of a quality that depend on the scene.

#include "halflight/bake/bake.h"
#include "halflight/unwrap/unwrap.h"

namespace halflight {

/// resolveQuality(); of a scene with much metal, previews have directions too: metal shows nothing but what its lobe
/// meets.
BakeQuality qualityOf(const BakeSettings& settings, const Scene& scene);

/// How a scene is unwrapped.
UnwrapSettings unwrapSettings(const Scene& scene, const BakeSettings& settings);

} // namespace halflight
