#pragma once
// Surfaces on lines, in a list of their own.

#include "halflight/bake/integrator.h"

namespace halflight {

/// By segment, as Integrator::surfacesAlong().
using SurfacesAlong = std::vector<std::optional<vec2>>;

inline Result<SurfacesAlong> surfacesAlong(const Integrator& integrator, std::span<const Segment> segments)
{
    SurfacesAlong surfaces(segments.size());
    if (Status s = integrator.surfacesAlong(segments, surfaces); !s) return s.error();
    return surfaces;
}

} // namespace halflight
