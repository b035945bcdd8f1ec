#pragma once
// Light that reflection probes show, and light that surfaces reflect by their specular lobes.

#include "transport/sample/path_tracer.h"

#include "halflight/bake/integrator.h"
#include "halflight/base/image.h"

#include <atomic>
#include <span>

namespace halflight {

/// What the picture around a point is made from.
struct RadianceSources {
    const PathTracer& paths;
    const IntegrationSettings& settings;
    std::span<const ImageRgb32f> lightmap; ///< irradiance by page, lux
    int raysPerTexel = 1;
};
/// As Integrator::radianceAround().
Status traceRadianceAround(const RadianceSources& sources, vec3 position, ImageRgb32f& map, const Progress& progress,
                           std::atomic<uint64_t>& rays);

/// As Integrator::specularLight().
Status traceSpecularLight(const PathTracer& paths, const IntegrationSettings& settings,
                          std::span<const SurfacePoint> points, std::span<const vec3> views,
                          std::span<SpecularEstimate> out, const Progress& progress, std::atomic<uint64_t>& rays);

} // namespace halflight
