#pragma once
// What pipelines do where their rays end.

#include "gpu/compute.h"

#include "shaders/bake/nearest.rahit.h"
#include "shaders/bake/nearest.rchit.h"
#include "shaders/bake/nearest.rmiss.h"
#include "shaders/bake/transmittance.rahit.h"
#include "shaders/bake/transmittance.rahit.tinted.h"
#include "shaders/bake/transmittance.rmiss.h"
#include "shaders/bake/transmittance.rmiss.tinted.h"

namespace halflight {

/// Of rays that find the nearest surface.
inline gpu::RayShaders::Ends nearestEnds()
{
    return {bake_nearest_rmiss, bake_nearest_rchit, bake_nearest_rahit};
}

/// Of rays that surfaces let through. `tinted`: by colour, of scenes whose glass has one.
inline gpu::RayShaders::Ends throughEnds(bool tinted)
{
    if (tinted) return {bake_transmittance_rmiss_tinted, {}, bake_transmittance_rahit_tinted};
    return {bake_transmittance_rmiss, {}, bake_transmittance_rahit};
}

} // namespace halflight
