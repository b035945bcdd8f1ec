#pragma once
// Incoming radiance and light visibility at points in space.

#include "transport/sample/path_tracer.h"
#include "transport/trace/device_paths.h"

#include <atomic>
#include <span>
#include <vector>

namespace halflight {

/// Seed of shadow rays of masks and probes.
constexpr uint32_t kShadowSeed = 0x5eed0001u;

/// Where rays of probes start: 0.1 mm beside the probes in a scene of 12 m. Surfaces often lie in planes through the
/// places of a regular grid. A ray from a point in a surface's plane may end on that surface at once, by rounding.
std::vector<vec3> besideProbes(const RayTracer& surfaces, std::span<const vec3> positions);

/// As Integrator::probes(); `components` is empty, or as of probesByComponent().
Status traceProbes(const PathTracer& paths, const IntegrationSettings& settings, std::span<const vec3> positions,
                   std::span<const uint32_t> which, int samples, std::span<ProbeEstimate> out,
                   std::span<SphericalHarmonicsL2> components, const Progress& progress, std::atomic<uint64_t>& rays);

/// The same with its paths on a device: the same samples.
Status traceProbesOn(const DevicePaths& device, const PathTracer& paths, const IntegrationSettings& settings,
                     std::span<const vec3> positions, std::span<const uint32_t> which, int samples,
                     std::span<ProbeEstimate> out, std::span<SphericalHarmonicsL2> components, const Progress& progress,
                     std::atomic<uint64_t>& rays);

} // namespace halflight
