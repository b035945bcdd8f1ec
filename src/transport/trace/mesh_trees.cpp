#include "transport/trace/mesh_trees.h"

#include <algorithm>
#include <map>
#include <utility>

namespace halflight {
namespace {

MeshTree treeOfObject(const BakeGeometry& geometry, const Materials& materials, uint32_t firstPart, uint32_t endPart)
{
    MeshTree tree;
    tree.firstPart = firstPart;
    tree.endPart = endPart;
    const uint32_t first = geometry.parts[firstPart].firstTriangle;
    for (uint32_t kind = 0; kind < KindCount; ++kind) {
        for (uint32_t p = firstPart; p < endPart; ++p) {
            const BakeGeometry::Part& part = geometry.parts[p];
            if (part.triangleCount == 0 || part.side == SurfaceSide::Back || kindOf(materials, part) != kind) continue;
            for (uint32_t t = 0; t < part.triangleCount; ++t) tree.triangles.push_back(part.firstTriangle - first + t);
        }
        tree.firstOfKind[kind + 1] = uint32_t(tree.triangles.size());
    }
    tree.triangles.shrink_to_fit();
    return tree;
}

} // namespace

GeometryKind kindOf(const Materials& materials, const BakeGeometry::Part& part)
{
    if (!part.castShadows) return NoShadow;
    return materials.of(part.firstTriangle).opaque ? Opaque : Transparent;
}

MeshTrees::MeshTrees(const BakeGeometry& geometry, const Materials& materials)
{
    std::map<std::pair<int, bool>, uint32_t> treeOfMesh; // by mesh, and whether any part casts shadows
    const std::vector<BakeGeometry::Part>& parts = geometry.parts;
    for (uint32_t p = 0, end = 0; p < parts.size(); p = end) {
        bool castShadows = false;
        for (end = p; end < parts.size() && parts[end].object == parts[p].object; ++end)
            castShadows = castShadows || parts[end].castShadows;
        if (parts[p].instance == BakeGeometry::kOwn) continue;
        const auto [entry, isFirst] = treeOfMesh.try_emplace({parts[p].mesh, castShadows}, uint32_t(trees.size()));
        if (isFirst) trees.push_back(treeOfObject(geometry, materials, p, end));
        instances.push_back({entry->second, parts[p].firstTriangle, &geometry.instances[parts[p].instance]});
    }
    instances.shrink_to_fit();
}

std::size_t MeshTrees::byteCount() const
{
    std::size_t bytes = trees.capacity() * sizeof(MeshTree) + instances.capacity() * sizeof(Instance);
    for (const MeshTree& tree : trees) bytes += tree.triangles.capacity() * sizeof(uint32_t);
    return bytes;
}

} // namespace halflight
