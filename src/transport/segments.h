#pragma once

#include "transport/trace/ray_tracer.h"

#include "halflight/bake/integrator.h"

namespace halflight {

/// As Integrator::surfacesAlong().
Status traceSegments(const RayTracer& tracer, std::span<const Segment> segments, std::span<std::optional<vec2>> out);

} // namespace halflight
