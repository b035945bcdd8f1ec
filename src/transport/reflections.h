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
    std::span<const std::span<const ImageRgb32f>> lightmaps; ///< irradiance by page, lux: of all light; or by component
    int raysPerTexel = 1;
};
/// As Integrator::radianceAround(), with one map; or as radianceAroundByComponent().
Status traceRadianceAround(const RadianceSources& sources, vec3 position, std::span<ImageRgb32f> maps,
                           const Progress& progress, std::atomic<uint64_t>& rays);

/// As Integrator::specularLight().
Status traceSpecularLight(const PathTracer& paths, const IntegrationSettings& settings,
                          std::span<const SurfacePoint> points, std::span<const vec3> views,
                          std::span<SpecularEstimate> out, const Progress& progress, std::atomic<uint64_t>& rays);

} // namespace halflight
