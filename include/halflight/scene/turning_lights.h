#pragma once
// Directional lights that turn after a bake (spec S34): a sun by the time of day. A bake holds what surfaces reflect of
// such a light for a few directions, each as a light group; weights blend them. Its direct light is of run time.

#include "halflight/scene/scene.h"

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace halflight {

/// Directions of one light.
constexpr std::size_t kMostDirections = 12;
/// Directions nearer to one another say the same twice.
constexpr float kLeastStepRadians = kPi / 180.0f;
/// Between directions this far apart in the open, a sun's bounced light is off by 5 to 6 % of its mean; between walls
/// it is by 3 to 5 % at 15 degrees (docs/lab/turning-suns.md).
constexpr float kMostStepRadians = kPi / 9.0f;

/// Whether the bake holds bounced light of several directions of the light.
inline bool turns(const Light& light)
{
    return light.baking.turning.group >= 0;
}

/// The weights, by direction, of what is baked for light along each of `directions`, so that it is that of light along
/// `direction`: at least 0, at most three above it. Irradiance of a plane is linear in the direction while it is lit,
/// so they minimize
///     |sum w_i d_i - d|^2 / 2 + sum w_i |d_i - d|^2 / 50,   w_i >= 0
/// so that a direction of the bake has the weight 1 alone. The second term prefers the nearest directions. The weights
/// are continuous in d. Beyond all directions they are about the cosine to the nearest one, and never all 0. All
/// vectors are of length 1.
std::vector<float> weightsOfDirections(std::span<const vec3> directions, vec3 direction);

/// The name of the light group of direction `index`, for a light's name.
std::string nameOfDirection(const std::string& light, std::size_t index);

/// The largest step, in radians, of a way that leads to all directions by steps that are as small as can be: the
/// longest edge of their least spanning tree. 0 for fewer than two.
float largestStep(std::span<const vec3> directions);

/// How far a direction is from the nearest of others, radians.
float angleToNearest(std::span<const vec3> directions, vec3 direction);

/// What is wrong with the directions of a light that is baked to turn, as sentences with a cure; empty for nothing.
std::vector<std::string> sparseDirections(const Light& light);

} // namespace halflight
