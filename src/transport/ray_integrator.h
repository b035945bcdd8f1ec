#pragma once

#include "transport/trace/ray_kernels.h"

#include "halflight/bake/integrator.h"

namespace halflight {

/// The integrators of IntegratorKind, whatever traces the rays. `geometry` and `scene` outlive it. Null where the
/// kernels could not be made.
std::unique_ptr<Integrator> makeRayIntegrator(const Scene& scene, const BakeGeometry& geometry,
                                              const IntegrationSettings& settings, const MakeKernels& makeKernels);

} // namespace halflight
