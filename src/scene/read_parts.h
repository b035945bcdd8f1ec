#pragma once
// The steps of readScene(): textures, materials, meshes.

#include "halflight/scene/gltf.h"
#include "scene/document.h"
#include "scene/settings.h"

#include <optional>

namespace halflight {

struct MaterialsRead {
    std::vector<Material> materials; ///< as many as the file's, in its order
    std::vector<Texture> textures;   ///< those that a material uses
    std::vector<std::string> warnings;
};
/// Marks the rules of `file` that matched.
Result<MaterialsRead> readMaterials(const SourceDocument& document, FileSettings& file, const ReadOptions& options);

struct MeshRead {
    Mesh mesh; ///< parts: the primitives that are triangles and have positions
    std::vector<std::string> warnings;
    std::size_t flatParts = 0;    ///< parts whose normals were invented
    std::size_t tangentParts = 0; ///< parts whose tangents were
};
/// `weights` of the morph targets: the node's, or the mesh's own where the node has none.
Result<MeshRead> readMesh(const SourceDocument& document, int mesh, const std::vector<double>& weights,
                          const std::vector<Material>& materials);

/// Whether a texture of the material, those of extensions included, reads TEXCOORD_n.
bool readsTexCoord(const Json& material, int n);

/// Triangle list of a glTF primitive's mode from its indices (empty: 0, 1, 2, … vertexCount - 1).
std::vector<uint32_t> trianglesOf(int mode, const std::vector<uint32_t>& indices, std::size_t vertexCount);

} // namespace halflight
