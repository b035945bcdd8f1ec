#pragma once
// Whether a baked file is still what its bake made.

#include "scene/document/document.h"

#include "halflight/scene/baked_scene.h"

namespace halflight {

/// Warns of what was changed since the bake, and of what a tool dropped of it (`lost`, too). `shift` takes positions of
/// the file to the scene's.
void checkAgainstBake(const SourceDocument& document, const Json& root, const glm::dvec3& shift, BakedScene& baked);

/// Of a file without a bake: warns where it once had one.
void checkLostBake(const SourceDocument& document, BakedScene& baked);

/// Warns of settings that say something else than at the bake, where a bake alone can heed them.
void checkSettingsOfBake(const SourceDocument& document, const Json& root, Scene& scene);

} // namespace halflight
