#pragma once
// How bright the lights of a scene are beside one another.

#include "halflight/scene/scene.h"

#include <vector>

namespace halflight {

/// Whether a light has a place and reaches everything.
bool hasNoRange(const Light& light);

/// For each light without a range, sqrt(I / E) in metres, with E the bright level of all other point and spot lights.
/// At sqrt(I / E) / sqrt(share) its illuminance I / d² is that share of E. Sun and sky do not count, since a sun may be
/// dimmed at run time. Infinite without other lights.
std::vector<float> levelDistances(const Scene& scene, const std::vector<const Light*>& lights);

} // namespace halflight
