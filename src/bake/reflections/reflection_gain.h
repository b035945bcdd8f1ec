#pragma once
// What reflection probes are worth: how much nearer to the truth specular light comes by them.

#include "bake/reflections/specular_points.h"

#include <span>
#include <vector>

namespace halflight {

/// A reflection probe and its tile (shading/reflection.h).
struct ReflectionPicture {
    ReflectionProbe probe;
    const ImageRgb32f* tile = nullptr;
};

/// How well a place is served by reflection probes, for the least squares of their share s of its specular light: the
/// error is that of own light + s (light of the probes - own light).
struct ReflectionTrust {
    vec3 position{0.0f};
    vec3 normal{0.0f};
    float along = 0.0f; ///< weighted sum of (truth - own) (probes - own)
    float total = 0.0f; ///< weighted sum of (probes - own)²
};

/// Which of the pictures to keep, with their fades, small boxes first: each gains most beside those before. `trusting`:
/// texels will say how far probes serve them, so that none is worse than without.
std::vector<ReflectionProbe> chooseByGain(std::span<const SpecularPoint> points,
                                          std::span<const ReflectionPicture> pictures, bool trusting);

/// Surfaces are farther from the truth with all of the pictures, in their order, than with none.
bool areWorseWith(std::span<const SpecularPoint> points, std::span<const ReflectionPicture> pictures, bool trusting);

/// What finished probes, in their order, are worth at the points that they serve.
std::vector<ReflectionTrust> trustOf(std::span<const SpecularPoint> points,
                                     std::span<const ReflectionPicture> pictures);

/// Writes the probes' trust into the fourth channel of the directions' pages, between the points by distance.
/// `pointCount`: of all points, those without a probe included.
void putTrust(const CachedIntegrator& cached, std::span<const ReflectionTrust> trust, std::size_t pointCount,
              std::vector<ImageRgba8>& directions);

} // namespace halflight
