#pragma once
// What the writer says of objects: a record in each of their nodes, and lightmap coordinates in their meshes.

#include "scene/format/at_bake.h"
#include "scene/write/meshes/write_meshes.h"

namespace halflight {

/// Node extension of objects.
constexpr const char* kNodeExtension = "HALFLIGHT_node";

class NodeWriter {
public:
    /// All of them outlive this.
    NodeWriter(DocumentPatcher& patcher, const SourceDocument& source, const BakedScene& baked, const AtBake& atBake,
               const std::vector<int>& materials);

    Status write();
    /// Nodes that were written with a lightmap.
    [[nodiscard]] std::size_t lightmapped() const { return lightmapped_; }

private:
    using Objects = std::vector<const Object*>; ///< of one node

    Json& extensionsOf(int node) { return patcher_.json["nodes"][std::size_t(node)]["extensions"]; }
    [[nodiscard]] Status check(const Objects& objects, bool lightmapped, const std::string& path) const;
    /// `surface`: at the bake, of static objects.
    Status writeNode(int node, const Objects& objects, const std::optional<SurfaceAtBake>& surface);
    /// The member "lightmap" of a node's record.
    Json lightmapJson(int node, const Objects& objects);
    void writeInstances(int node, const Objects& objects);

    DocumentPatcher& patcher_;
    const SourceDocument& source_;
    const BakedScene& baked_;
    const Scene& scene_;
    const AtBake& atBake_;
    std::vector<FileLayout> layouts_; // by scene mesh
    MeshWriter meshes_;
    std::size_t lightmapped_ = 0;
};

} // namespace halflight
