#pragma once
#include "scene/document/document.h"
#include "scene/read/geometry/nodes.h"

#include "halflight/scene/baked_scene.h"

namespace halflight {

/// `reflectionProbes` of the root extension, which may be null. `shift` takes positions relative to the file's origin
/// to the scene's: zero but for files that were moved.
Result<ReflectionSet> readReflections(const SourceDocument& document, const Json& json, const glm::dvec3& shift);

/// Picture, size and unit of so many tiles: of these, or of a light group's `reflections`. `path` is of `json`.
Status readReflectionPicture(const SourceDocument& document, const Json& json, std::size_t probes,
                             const std::string& path, ReflectionSet& set);

/// Fills Scene::reflectionBoxes by the nodes that ask for one; where none does, by what an earlier bake recorded.
Status readReflectionBoxes(const SourceDocument& document, const std::vector<NodeState>& nodes, Scene& scene);

/// Whether a box has a volume: its transform is finite and has an inverse.
bool isBox(const mat4& worldFromBox);

} // namespace halflight
