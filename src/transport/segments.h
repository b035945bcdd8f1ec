#pragma once

#include "transport/trace/ray_kernels.h"

#include "halflight/bake/integrator.h"

namespace halflight {

/// As Integrator::surfacesAlong().
void traceSegments(const RayKernels& kernels, std::span<const Segment> segments, std::span<std::optional<vec2>> out);

} // namespace halflight
