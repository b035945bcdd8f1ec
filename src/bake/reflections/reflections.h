#pragma once
// Parts of the reflection probes' stage.

#include "halflight/bake/integrator.h"
#include "halflight/scene/baked_scene.h"

#include <span>
#include <string>
#include <vector>

namespace halflight {

struct CachedIntegrator;
struct LightmapPages;

/// Pages of each component in bakes with light groups, lux by page; empty in others.
struct ComponentLight {
    std::vector<std::span<const ImageRgb32f>> lightmaps;
};

/// Reflection probes where people look: the fewest places from which nearly all light probes are seen. Each has the box
/// that predicts best how far its surroundings are. Small boxes come first.
Result<std::vector<ReflectionProbe>> placeReflections(std::span<const Probe> lightProbes, const Integrator& integrator,
                                                      float sceneSizeMeters);

/// Reflection probes at places all over the scene. The box of each is that of its own surroundings, which ends nearby
/// where the place is open.
Result<std::vector<ReflectionProbe>> proposeReflections(std::span<const Probe> lightProbes,
                                                        const Integrator& integrator, float sceneSizeMeters);

/// Which of the probes to keep, small boxes first. `uses`: by probe and place of a probe, 0…1, how well the one serves
/// the other.
std::vector<std::size_t> chooseReflections(std::span<const ReflectionProbe> probes,
                                           std::vector<std::vector<float>> uses);

/// ReflectionProbe::fadeMeters of a box that ends at walls. Boxes of open places reach far beyond the scene.
float reflectionFade(const mat4& worldFromBox, float sceneSizeMeters);

/// The tile of a probe (shading/reflection.h) from the radiance around it: prefiltered with the GGX distribution, for a
/// surface seen along its normal (Karis 2013). `around`: the inner texels of level 0.
ImageRgb32f reflectionTile(const ImageRgb32f& around);

/// Reflection probes at the scene's own boxes, or where they bring what lightmapped surfaces reflect nearest to the
/// truth; none in a scene without light probes. `lightmap`: of all light. Writes how far texels trust the probes into
/// lightmapDirections. `size`: of a tile, if probes are few. With `components` the pictures of light groups are by
/// themselves.
Status bakeReflections(BakedScene& baked, const CachedIntegrator& cached, const LightmapPages& lightmap,
                       const ComponentLight& components, int size, std::vector<std::string>& warnings,
                       const Progress& progress);

} // namespace halflight
