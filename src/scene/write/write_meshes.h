#pragma once
// How the writer puts lightmap coordinates into a document's meshes.

#include "scene/document/patcher.h"
#include "scene/format/lightmap_layout.h"
#include "scene/format/material_sides.h"
#include "scene/write/cut_attributes.h"

#include "halflight/scene/baked_scene.h"

namespace halflight {

/// Makes the meshes of the written file: one for each scene mesh that has lightmap coordinates, and copies of it where
/// nodes need materials of their own (MOZ_lightmap). All share accessors.
class MeshWriter {
public:
    /// `layouts`: of each scene mesh; outlives this.
    MeshWriter(DocumentPatcher& patcher, const SourceDocument& source, const Scene& scene,
               const std::vector<FileLayout>& layouts);

    static constexpr int kAsInSource = -2; ///< of `materials`: the part has no lightmap material

    /// Points the node at the scene mesh's place in the file. `materials` has the material of each part (-1 default);
    /// nodes with equal `materials` share a mesh.
    Status setNodeMesh(int node, int sceneMesh, const std::vector<int>& materials);
    /// The material of a part in the written file, for that of its primitive in the source.
    int materialOf(const MeshPart& part, int source) { return sides_.of(source, part.side); }
    /// Gives the meshes their final indices; to be called once, after the last setNodeMesh().
    void finish();

private:
    /// A mesh of the file, and the place of each part of the scene's mesh among its primitives.
    struct Patched {
        Json json;
        std::vector<std::size_t> placeOfPart;
    };
    Result<Patched> patchedMesh(int sceneMesh);
    Result<Json> primitiveJson(const MeshPart& part, const FileLayout& layout, const Json& source,
                               const tinygltf::Primitive& primitive, const std::string& path);
    Result<int> remap(const MeshPart& part, int accessor, const std::string& attribute, Between between);

    DocumentPatcher& patcher_;
    const SourceDocument& source_;
    const Scene& scene_;
    const std::vector<FileLayout>& layouts_;
    MaterialSides sides_;
    std::map<int, Patched> patched_;                                          ///< by scene mesh
    std::map<std::pair<int, std::vector<int>>, std::size_t> byKey_;           ///< index into meshes_
    std::vector<std::pair<int, Json>> meshes_;                                ///< source mesh, JSON
    std::vector<std::pair<int, std::size_t>> nodes_;                          ///< node, index into meshes_
    std::map<std::tuple<const MeshPart*, int, Between, bool>, int> remapped_; ///< the last: negated
};

} // namespace halflight
