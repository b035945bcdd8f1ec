#pragma once
// Parts of the reflection probes' stage.

#include "halflight/bake/integrator.h"

#include <span>
#include <vector>

namespace halflight {

/// Reflection probes where people look: the fewest places from which nearly all light probes are seen. Each has the box
/// that predicts best how far its surroundings are. Small boxes come first.
std::vector<ReflectionProbe> placeReflections(std::span<const Probe> lightProbes, const Integrator& integrator,
                                              float sceneSizeMeters);

/// Reflection probes at places all over the scene. The box of each is that of its own surroundings, which ends nearby
/// where the place is open.
std::vector<ReflectionProbe> proposeReflections(std::span<const Probe> lightProbes, const Integrator& integrator,
                                                float sceneSizeMeters);

/// Which of the probes to keep, small boxes first. `uses`: by probe and place of a probe, 0…1, how well the one serves
/// the other.
std::vector<std::size_t> chooseReflections(std::span<const ReflectionProbe> probes,
                                           std::vector<std::vector<float>> uses);

/// ReflectionProbe::fadeMeters of a box that ends at walls. Boxes of open places reach far beyond the scene.
float reflectionFade(const mat4& worldFromBox, float sceneSizeMeters);

/// The tile of a probe (shading/reflection.h) from the radiance around it: prefiltered with the GGX distribution, for a
/// surface seen along its normal (Karis 2013). `around`: the inner texels of level 0.
ImageRgb32f reflectionTile(const ImageRgb32f& around);

} // namespace halflight
