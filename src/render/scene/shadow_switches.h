#pragma once
// Shadow switches of objects that were turned since the scene was loaded.

#include "halflight/render/frame.h"

#include <cstdint>
#include <string>
#include <vector>

namespace halflight {

/// Object::castShadows and receiveShadows as the bake saw them.
struct ShadowSwitches {
    bool cast = true;
    bool receive = true;
};
std::vector<ShadowSwitches> shadowSwitches(const Scene& scene);

/// Sentences about static objects whose switches differ from those of the bake: baked shadows do not follow. Empty for
/// modes and lights that have no baked shadows.
std::vector<std::string> switchWarnings(const BakedScene& baked, const std::vector<ShadowSwitches>& atBake,
                                        RunMode mode);

} // namespace halflight
