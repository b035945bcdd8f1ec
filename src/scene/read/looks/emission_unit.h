#pragma once
// What emission in a file counts: cd/m2, or Blender's watts.

#include "scene/document/document.h"
#include "scene/settings/settings.h"

#include <optional>

namespace halflight {

/// Scales the materials' emission where it counts Blender's watts. `ofFile`: what the file says itself; nits cannot be
/// overruled then, since such a file was scaled already. `asked`: what the caller or the settings file says. A file of
/// Blender's exporter that says nothing gets a warning.
void applyEmissionUnit(const SourceDocument& document, std::optional<EmissionUnit> ofFile,
                       std::optional<EmissionUnit> asked, Scene& scene);

/// Writes the scaled emission into the document's materials, and into its scene's extras that it is in nits. Nothing
/// where Scene::emissionScale is 1.
void writeScaledEmission(Json& document, const Scene& scene);

/// Writes emission that is not the document's into materials, of scene materials whose emission was changed since it
/// was read. `materials`: the file's material of each.
void writeChangedEmission(Json& document, const Scene& scene, const std::vector<int>& materials);

} // namespace halflight
