#pragma once
// Scenes of the frame benchmark.

#include "halflight/scene/baked_scene.h"

namespace halflight::bench {

/// What a bake would have left, without baking: every static object on one lightmap page and one mask of the usual
/// size in as many layers as they need, a grid of probes, and for mixed lights their baking output (the first that cast
/// get the channels). Lightmap and mask hold a pattern; what they hold does not change what drawing them costs.
BakedScene withStandInBake(Scene scene, MixedLightingMode mode);

/// A few dynamic spheres where the camera looks, moving as `phase` goes on.
void addDynamicSpheres(Scene& scene, const Camera& camera, int count);

/// Its first camera, or one inside its bounds that looks along the longest side.
Camera cameraOf(const Scene& scene);

/// A sun, if the scene has no directional light.
void ensureSun(Scene& scene);

/// 1,000 objects on a ground: spheres and boxes of 12 meshes, one in twenty of them dynamic; a sun, four spots, two
/// points.
Scene thousandObjects();

/// A ground of 64 x 64 m, seen from above, under n x n shadowless point lights with ranges of `reach` times their
/// distance. The wider the reach the more lights each point gets.
Scene lightField(int n, float reach);
/// The same ground under so many mixed point lights, each of which reaches all of it.
Scene overlappingLamps(int count);
/// Mean number of those lights that reach a point of the ground.
double lightsPerPoint(const Scene& scene);

} // namespace halflight::bench
