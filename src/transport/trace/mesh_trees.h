#pragma once
// Shared meshes, each of which has a tree of its own, and their instances in the scene.

#include "transport/trace/materials.h"

#include "halflight/bake/bake_geometry.h"

#include <array>
#include <vector>

namespace halflight {

/// Kinds of triangles: opaque ones, masked and blended ones, and those that only camera rays hit.
enum GeometryKind : uint32_t { Opaque, Transparent, NoShadow, KindCount };

GeometryKind kindOf(const Materials& materials, const BakeGeometry::Part& part);

/// The tree of a shared mesh. Objects that cast no shadow have a tree of their own, as all its triangles are of another
/// kind.
struct MeshTree {
    uint32_t firstPart = 0;                            ///< of the first object with this tree
    uint32_t endPart = 0;                              ///< after its last
    std::vector<uint32_t> triangles;                   ///< sorted by kind; counted from the object's first
    std::array<uint32_t, KindCount + 1> firstOfKind{}; ///< index into `triangles`; then their number
};

/// Trees of the shared meshes, and instances. The number of an instance's list of triangles is KindCount plus its index
/// here.
struct MeshTrees {
    struct Instance {
        uint32_t tree = 0;          ///< index into `trees`
        uint32_t firstTriangle = 0; ///< of its object
        const BakeGeometry::Instance* place = nullptr;
    };
    std::vector<MeshTree> trees;
    std::vector<Instance> instances;

    MeshTrees(const BakeGeometry& geometry, const Materials& materials);

    [[nodiscard]] const MeshTree& treeOf(const Instance& instance) const { return trees[instance.tree]; }
    /// Triangle of the bake. `index`: into MeshTree::triangles.
    [[nodiscard]] uint32_t triangleOf(const Instance& instance, uint32_t index) const
    {
        return instance.firstTriangle + treeOf(instance).triangles[index];
    }
    [[nodiscard]] std::size_t byteCount() const;
};

} // namespace halflight
