#pragma once
// Rigid poses.

#include "halflight/base/math.h"

namespace halflight {

/// Rigid pose at `position` whose -Z points along `direction` (not zero) and whose Y is near `up`, or near some axis
/// where those are parallel.
mat4 poseLookingAlong(vec3 position, vec3 direction, vec3 up = vec3(0.0f, 1.0f, 0.0f));

/// The rigid part of an affine transform, for lights and cameras, which no scale changes: the same position, -Z and, as
/// far as possible, Y. A transform that flattens Z gives an unrotated pose.
mat4 rigidPose(const mat4& transform);

} // namespace halflight
