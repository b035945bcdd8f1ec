#pragma once

#include "halflight/bake/integrator.h"

namespace halflight {

/// Path tracer on the CPU with Embree, on all cores: the reference integrator.
Result<std::unique_ptr<Integrator>> makeEmbreeIntegrator(const Scene& scene, const BakeGeometry& geometry,
                                                         const IntegrationSettings& settings);

/// The picture `halflight render --reference SPP` writes: the whole scene, static and dynamic, path traced with the
/// integrator of the bake from the given camera; linear radiance in nits.
/// Surfaces that the camera sees reflect by glTF's BRDF (shading/brdf.h), without normal maps; light that reaches them
/// by way of other surfaces is carried on as by diffuse surfaces of shading::transportAlbedo().
Result<ImageRgb32f> renderReference(const Scene& scene, const Camera& camera, ivec2 size, int samplesPerPixel,
                                    int bounces, uint32_t seed, const Progress& progress = {});

} // namespace halflight
