#include "transport/trace/ray_scene.h"

namespace halflight {

RayScene::RayScene(const Scene& scene, const BakeGeometry& geometry)
    : geometry_(geometry), materials_(scene, geometry), meshTrees_(geometry, materials_)
{
    Bounds bounds;
    for (const BakeGeometry::Part& part : geometry_.parts) {
        if (part.triangleCount == 0 || part.side == SurfaceSide::Back) continue;
        const TransportMaterial& material = materials_.of(part.firstTriangle);
        anyBlended_ = anyBlended_ || material.blended;
        anyTinted_ = anyTinted_ || material.tints;
        if (part.instance != BakeGeometry::kOwn) {
            for (uint32_t v = part.firstVertex; v < part.firstVertex + part.vertexCount; ++v)
                bounds.extend(geometry_.positionOf(part, v));
            continue;
        }
        std::vector<uint32_t>& list = trianglesOfKind_[kindOf(materials_, part)];
        for (uint32_t t = part.firstTriangle; t < part.firstTriangle + part.triangleCount; ++t) {
            list.push_back(t);
            bounds.extend(geometry_.boundsOf(t));
        }
    }
    firstHit_.reserve(KindCount + meshTrees_.instances.size() + 1);
    firstHit_.assign(1, 0u);
    for (const auto& list : trianglesOfKind_) firstHit_.push_back(firstHit_.back() + uint32_t(list.size()));
    for (const MeshTrees::Instance& instance : meshTrees_.instances)
        firstHit_.push_back(firstHit_.back() + meshTrees_.treeOf(instance).firstOfKind[KindCount]);
    sceneScale_ = bounds.empty() ? 1.0f : glm::length(bounds.size());
}

uint32_t RayScene::treeTriangleCount() const
{
    std::size_t count = 0;
    for (const auto& list : trianglesOfKind_) count += list.size();
    for (const MeshTree& tree : meshTrees_.trees) count += tree.triangles.size();
    return uint32_t(count);
}

std::size_t RayScene::byteCount() const
{
    std::size_t bytes = meshTrees_.byteCount();
    for (const auto& list : trianglesOfKind_) bytes += list.capacity() * sizeof(uint32_t);
    return bytes + firstHit_.capacity() * sizeof(uint32_t);
}

} // namespace halflight
