#pragma once
// The lightmap by path tracing: unbiased, the reference.

#include "transport/sample/path_tracer.h"
#include "transport/texels/texel_points.h"
#include "transport/trace/device_paths.h"

#include <atomic>

namespace halflight {

/// As Integrator::irradiance(), without fully baked lights: each sample is a path.
Status tracePathLightmap(const PathTracer& paths, const IntegrationSettings& settings, const TexelMap& map,
                         std::span<const uint32_t> texels, int samples, const TexelLight& out, const Progress& progress,
                         std::atomic<uint64_t>& rays);

/// The same of light as one, on a device: the same samples.
Status tracePathLightmapOn(const DevicePaths& device, const PathTracer& paths, const IntegrationSettings& settings,
                           const TexelMap& map, std::span<const uint32_t> texels, int samples, const TexelLight& out,
                           const Progress& progress, std::atomic<uint64_t>& rays);

/// As Integrator::irradiance() for rough requests.
Status traceRoughLightmap(const PathTracer& paths, const IntegrationSettings& settings, const TexelMap& map,
                          std::span<const uint32_t> texels, int samples, std::span<IrradianceEstimate> out,
                          const Progress& progress, std::atomic<uint64_t>& rays);

/// As Integrator::sides().
Status traceSides(const PathTracer& paths, const IntegrationSettings& settings, std::span<const SurfacePoint> points,
                  std::span<const vec3> eyes, int samples, int walks, std::span<SideEstimate> out,
                  const Progress& progress, std::atomic<uint64_t>& rays);

} // namespace halflight
