#pragma once
// Reflection probes of a state of light groups (spec S33).

#include "halflight/scene/baked_scene.h"

#include <vector>

namespace halflight {

/// Adds the pictures of the groups, each times its weight, to that of the bake's reflection probes.
void composeReflections(BakedScene& baked, const std::vector<vec3>& weights);

} // namespace halflight
