#pragma once
// Radiosity solution: light after any number of bounces, by sweeps over the form factors.

#include "transport/radiosity/form_factors.h"
#include "transport/radiosity/radiance_cache.h"

namespace halflight {

/// Cache and the statistics from which guides are built.
struct RadiositySolution {
    RadianceCache cache;
    /// Patches of samples and links are numbers of unknowns of the linear system, or kNoPatch.
    FormFactors factors;
    std::vector<PatchId> patchOfUnknown; ///< unknowns of elements have their patch
    std::vector<float> illuminance;      ///< by front chart patch: light of sky and emitters along rays
    std::vector<float> ofComponents;     ///< the same by front chart patch and component
};

/// Each bounce is one sweep: a Jacobi iteration of the radiosity equation, so `bounces` iterations are light after at
/// most as many reflections. Sweeps end early where further ones would add less than 0.2 %. Patches without samples
/// take the unknown of a patch beside them. Moves the layout out of `patches`. `components`: number of components, each
/// of which has sweeps of its own over the same links; 0 = light is one.
RadiositySolution solveRadiosity(Patches& patches, FormFactors factors, int bounces, int components = 0);

} // namespace halflight
