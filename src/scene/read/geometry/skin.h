#pragma once
// Skinned meshes at rest.

#include "scene/read/geometry/nodes.h"

namespace halflight {

/// Whether the node's mesh is placed by joints: it has a skin, some primitive has joints and weights, and no instances.
bool isSkinned(const SourceDocument& document, int node);

/// World transforms of all nodes of the file, those outside the scene included.
Result<std::vector<glm::dmat4>> worldTransforms(const SourceDocument& document);

/// Moves the vertices of `mesh` (the node's, read and morphed) to where the joints of the node's skin hold them at
/// rest: p' = sum_j weight_j * worldFromJoint_j * inverseBind_j * p (glTF 2.0, section 3.7.3.3). The node's own
/// transform counts only for primitives without joints. Vertices are then relative to the result, worldFromObject: the
/// middle of their bounds, mirrored where the joints mirror. Errors: a skin that is no skin.
Result<glm::dmat4> skinMesh(const SourceDocument& document, int node, const std::vector<glm::dmat4>& worldFromNode,
                            Mesh& mesh, std::vector<std::string>& warnings);

} // namespace halflight
