#pragma once
// Stages of bakes with light groups (spec S33): the light of each component, from estimates to pages and probes.

#include "bake/first_stages.h"
#include "bake/lights/main_light.h"
#include "bake/probes/probes.h"
#include "bake/reflections/reflections.h"
#include "bake/seams/seams.h"

#include "halflight/scene/light_groups.h"

#include <span>
#include <vector>

namespace halflight {

/// The scene's groups, which are white from then on, noted in the baked scene. Lights that turn are one for each of
/// their directions until finishGroups(). Errors: those of groupLights().
Result<LightGrouping> beginGroups(GroupChoice choice, MixedLightingMode mode, Scene& scene, BakedScene& baked);

/// For the integrator: group g is component g + 1.
LightComponents componentsOf(const LightGrouping& grouping);

/// Estimates of the map's texels, and the light of each component.
Status traceComponents(const BakeRun& run, const CachedIntegrator& cached, PreparedLightmap& lightmap,
                       std::span<IrradianceEstimate> estimates, ComponentSignals& components);

/// Fills and encodes the pages of each component, into the baked scene. Releases `components`. `main`: subtractive's
/// main light, or null; each component has a lower limit of its shadows.
Status componentPagesStage(const BakeRun& run, const CachedIntegrator& cached, ComponentSignals& components,
                           const std::vector<uint8_t>& valid, const MainLight* main,
                           const std::vector<SeamSample>& seams, BakeReport& report);

/// What addProbeLayers() will do to the set, for its components.
void addLayersOfComponents(BakedProbes& probes);

/// Takes the components of probes into the baked scene: probes keep the rest.
void keepComponentsOfProbes(const BakedProbes& probes, BakedScene& baked);

/// Light of a bake while its groups are white: of all, and of each component.
struct WhitePages {
    std::vector<ImageRgb32f> irradiance; ///< lux
    std::vector<ImageRgba8> directions;  ///< none, or by page
    ComponentLight components;           ///< the bake's own pages
};
WhitePages whitePages(const BakeResult& result);

/// Gives the scene its own light in place of white groups, and the groups the white light of a finished bake.
void finishGroups(LightGrouping& grouping, BakeResult& result);

} // namespace halflight
