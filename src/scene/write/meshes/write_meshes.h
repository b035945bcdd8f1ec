#pragma once
// How the writer puts lightmap coordinates into a document's meshes.

#include "scene/document/patcher.h"
#include "scene/format/lightmap_layout.h"
#include "scene/format/material_sides.h"
#include "scene/write/meshes/cut_attributes.h"
#include "scene/write/meshes/variant_groups.h"

#include "halflight/scene/baked_scene.h"

namespace halflight {

/// Makes the meshes of the written file: one for each scene mesh that has lightmap coordinates. They share accessors.
class MeshWriter {
public:
    /// `layouts`: of each scene mesh. `materials`: in the file, of each scene material. Both outlive this.
    MeshWriter(DocumentPatcher& patcher, const SourceDocument& source, const BakedScene& baked,
               const std::vector<FileLayout>& layouts, const std::vector<int>& materials);

    /// Whether the part has a copy of its source's material, which a light group made.
    [[nodiscard]] bool isCopied(const MeshPart& part) const;
    /// Points the node at the scene mesh's place in the file.
    Status setNodeMesh(int node, int sceneMesh);
    /// Gives the meshes their final indices; to be called once, after the last setNodeMesh().
    void finish();

private:
    Result<Json> patchedMesh(int sceneMesh);
    Result<Json> primitiveJson(const MeshPart& part, const FileLayout& layout, const Json& source,
                               const std::string& path);
    Result<int> remap(const MeshPart& part, int accessor, const std::string& attribute, Between between);

    DocumentPatcher& patcher_;
    const SourceDocument& source_;
    const Scene& scene_;
    const std::vector<FileLayout>& layouts_;
    const std::vector<int>& materials_;
    MaterialSides sides_;
    VariantGroups variants_;
    std::map<int, std::size_t> indexOf_;                                      ///< by scene mesh: index into meshes_
    std::vector<std::pair<int, Json>> meshes_;                                ///< source mesh, JSON
    std::vector<std::pair<int, std::size_t>> nodes_;                          ///< node, index into meshes_
    std::map<std::tuple<const MeshPart*, int, Between, bool>, int> remapped_; ///< the last: negated
};

} // namespace halflight
