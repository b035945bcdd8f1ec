#pragma once
// `--light NAME:intensity=…,color=r,g,b,direction=x,y,z`: a light changed at run time, by the keys of
// light_override.cpp.

#include "console.h"

#include "halflight/base/result.h"
#include "halflight/scene/scene.h"

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace halflight::cli {

struct LightOverride {
    std::string name;
    std::optional<float> intensity;
    std::optional<vec3> color;
    std::optional<vec3> direction;
    std::optional<dvec3> position; ///< in the file's world
    std::optional<float> rangeMeters;
    std::optional<float> innerConeRadians;
    std::optional<float> outerConeRadians;
    std::optional<float> shadowStrength;
    ShadowBias shadowBias;
};

/// InvalidArgument with what is wrong in the text.
Result<LightOverride> parseLightOverride(const std::string& text);
/// Adds --light NAME:KEY=VALUE; each use appends to `lights`.
void addLights(CLI::App& app, std::vector<LightOverride>& lights, const std::string& description);
/// The scene's lights that are changed, with their indices: every light of a name. InvalidArgument for a name that no
/// light has.
Result<std::vector<std::pair<int, Light>>> changedLights(const Scene& scene, const std::vector<LightOverride>& changes);
/// The light with those changes. `originMeters` is the scene's.
Light overridden(Light light, const LightOverride& change, const dvec3& originMeters);

} // namespace halflight::cli
