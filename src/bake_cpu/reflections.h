#pragma once
// The picture around a reflection probe.

#include "bake_cpu/sample/path_tracer.h"

#include "halflight/base/image.h"

#include <atomic>
#include <span>

namespace halflight {

/// As Integrator::radianceAround(). False when cancelled.
bool traceRadianceAround(const PathTracer& paths, const IntegrationSettings& settings, vec3 position,
                         std::span<const ImageRgb32f> lightmap, ImageRgb32f& map, const Progress& progress,
                         std::atomic<uint64_t>& rays);

} // namespace halflight
