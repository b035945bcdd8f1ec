#pragma once
// The node hierarchy: which nodes are shown, where they are, what moves.

#include "scene/document/document.h"
#include "scene/read/geometry/animation.h"
#include "scene/settings/settings.h"

#include <string>
#include <vector>

namespace halflight {

struct NodeState {
    int node = -1;
    std::string name; ///< the node's, or "node 12"
    /// To the file's world; once the scene's local origin is known, to the scene's space.
    glm::dmat4 worldFromNode{1.0};
    bool visible = true;                ///< KHR_node_visibility, ancestors included
    bool animated = false;              ///< it or an ancestor is moved, shown or hidden by an animation
    bool morphed = false;               ///< an animation changes its morph weights
    std::optional<bool> isStaticExtras; ///< halflight_static of the nearest ancestor that has it
    std::optional<bool> isStaticFile;   ///< the same of the settings file
    ObjectSettings settings; ///< extras, then a bake's record, then the settings file; isStatic from the two above
};

/// The nodes of the default scene (all root nodes where the file has no scene), parents before children, siblings in
/// the file's order. Marks the rules of `file` that matched.
Result<std::vector<NodeState>> walkNodes(const SourceDocument& document, const AnimatedThings& animated,
                                         FileSettings& file, std::vector<std::string>& warnings);

/// The parent of each of the document's nodes, or -1.
std::vector<int> parentsOf(const Json& nodes);

/// The JSON of the scene that walkNodes() walks, or null.
const Json& activeScene(const SourceDocument& document);

/// Local transform of a node from its matrix or its translation, rotation and scale.
Result<glm::dmat4> localTransform(const Json& node, const std::string& path);

/// World transforms of an EXT_mesh_gpu_instancing node's instances relative to the node.
Result<std::vector<glm::dmat4>> instanceTransforms(const SourceDocument& document, int node);

/// A 4x4 matrix of an extension: 16 numbers, columns first.
bool readMatrix(const Json& value, glm::dmat4& matrix);

} // namespace halflight
