#pragma once
// Lights and cameras of nodes.

#include "scene/read/geometry/nodes.h"

namespace halflight {

/// The light on a node (light_shapes.h) with its settings; nothing where it has none. Marks matching rules of `file`.
/// The node's transform is relative to the scene's local origin already, which poses of an earlier bake are made
/// relative to.
Result<std::optional<Light>> readLight(const SourceDocument& document, const NodeState& state, const glm::dvec3& origin,
                                       const AnimatedThings& animated, FileSettings& file,
                                       std::vector<std::string>& warnings);

/// The camera on a node; nothing where it has none, or one that shows nothing (with a warning).
std::optional<Camera> readCamera(const SourceDocument& document, const NodeState& state,
                                 std::vector<std::string>& warnings);

} // namespace halflight
