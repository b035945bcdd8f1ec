#pragma once
// Meshes of a document: its triangles, with normals and tangents where the file leaves them out.

#include "halflight/scene/scene.h"
#include "scene/document/document.h"

namespace halflight {

struct MeshRead {
    Mesh mesh; ///< parts: the primitives that are triangles and have positions
    std::vector<std::string> warnings;
    std::size_t flatParts = 0;    ///< parts whose normals were invented
    std::size_t tangentParts = 0; ///< parts whose tangents were
};
/// `weights` of the morph targets: the node's, or the mesh's own where the node has none.
Result<MeshRead> readMesh(const SourceDocument& document, int mesh, const std::vector<double>& weights,
                          const std::vector<Material>& materials);

/// Triangle list of a glTF primitive's mode from its indices (empty: 0, 1, 2, … vertexCount - 1).
std::vector<uint32_t> trianglesOf(int mode, const std::vector<uint32_t>& indices, std::size_t vertexCount);

} // namespace halflight
