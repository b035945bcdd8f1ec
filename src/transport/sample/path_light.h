#pragma once
// Light by component: of one light group each, and of the rest (spec S33).

#include "transport/sample/running_moments.h"

#include "halflight/bake/integrator.h"

#include <span>
#include <vector>

namespace halflight {

/// Light that a path receives from the sources of one component.
struct PathLight {
    int component = 0;
    int reflections = 0; ///< before it arrives
    vec3 radiance{0.0f};
};
/// May have several entries of one component.
using PathLights = std::vector<PathLight>;

/// Estimate of one component at one texel. The terms are those of TexelEstimate.
struct ComponentEstimate {
    RunningMoments gathered;
    RunningMoments emitted;
};

/// Estimates of a request's texels; those of components by texel and component, or none.
struct TexelLight {
    std::span<IrradianceEstimate> texels;
    std::span<IrradianceEstimate> components;
};

} // namespace halflight
