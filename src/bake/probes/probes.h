#pragma once
// Light probes.

#include "halflight/bake/bake.h"
#include "halflight/bake/integrator.h"

#include <optional>
#include <string>
#include <vector>

namespace halflight {

struct CachedIntegrator;

/// A grid of probes over the bounds of the static objects. `spacingMeters`: 0 = by the scene's size.
ProbeSet probeGrid(const Scene& scene, float spacingMeters, std::vector<std::string>& warnings);

/// Gives the invalid probes of a grid the mean light and occlusion of their nearest valid neighbours along its axes, so
/// that trilinear interpolation darkens nothing beside walls. They stay marked as invalid.
void fillInvalidProbes(ProbeSet& grid);

/// How far probes see (ProbeSight), so that interpolation leaves out those behind a wall.
Result<ProbeSight> findProbeSight(const ProbeSet& set, const Integrator& integrator, const Progress& progress);

/// Probes, and check probes: estimates between them, which are not kept.
struct BakedProbes {
    ProbeSet set;
    std::vector<vec3> checkedAt;       ///< places beside surfaces, metres
    std::vector<ProbeEstimate> checks; ///< by place; those inside geometry and unlit ones are invalid
    /// By component, the radiance of each probe of the set; empty in bakes without light groups.
    std::vector<std::vector<SphericalHarmonicsL2>> components;
};
/// The probes (spec S14): those at the scene's own positions, with invalid ones marked; or, without positions, a grid
/// as `layout` says.
Result<BakedProbes> bakeProbes(const Scene& scene, float spacingMeters, ProbeLayout layout, bool denoise,
                               const CachedIntegrator& cached, std::vector<std::string>& warnings,
                               const Progress& progress);
/// How far the light of the finished probes is off between them. `baked` has the probes, with what they see. Adds a
/// warning that names places where it is off by more than ProbeCheck::kOff.
ProbeCheck checkProbes(const BakedScene& baked, const BakedProbes& probes, std::vector<std::string>& warnings);

} // namespace halflight
