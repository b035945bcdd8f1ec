#pragma once
// The triangles that rays can hit, by kind, and their numbers.

#include "transport/trace/materials.h"
#include "transport/trace/mesh_trees.h"

#include "halflight/shading/rays.h"

#include <algorithm>
#include <array>
#include <span>
#include <vector>

namespace halflight {

/// What kernels build their trees from: a list of triangles in world space for each kind, and instances of shared
/// meshes. A list's number is its kind, or KindCount plus the index of an instance. Immutable after construction.
class RayScene {
public:
    /// `geometry` and `scene` outlive it.
    RayScene(const Scene& scene, const BakeGeometry& geometry);
    RayScene(const RayScene&) = delete;
    RayScene& operator=(const RayScene&) = delete;

    [[nodiscard]] const BakeGeometry& geometry() const { return geometry_; }
    [[nodiscard]] const Materials& materials() const { return materials_; }
    [[nodiscard]] const MeshTrees& meshTrees() const { return meshTrees_; }
    /// As BakeGeometry counts them.
    [[nodiscard]] std::span<const uint32_t> trianglesOf(GeometryKind kind) const { return trianglesOfKind_[kind]; }
    [[nodiscard]] bool anyBlended() const { return anyBlended_; }
    /// Whether light that passes some surface takes a colour.
    [[nodiscard]] bool anyTinted() const { return anyTinted_; }

    /// A triangle of a list, as BakeGeometry counts them. `index`: in an instance's list, into MeshTree::triangles.
    [[nodiscard]] uint32_t triangleOf(uint32_t list, uint32_t index) const
    {
        return list < KindCount ? trianglesOfKind_[list][index]
                                : meshTrees_.triangleOf(meshTrees_.instances[list - KindCount], index);
    }
    /// Number of a triangle among those of all lists, 0 … hitTriangleCount() - 1.
    [[nodiscard]] uint32_t hitIndex(uint32_t list, uint32_t index) const { return firstHit_[list] + index; }
    [[nodiscard]] uint32_t hitTriangleCount() const { return firstHit_.back(); }
    /// The triangle with that number, as BakeGeometry counts them.
    [[nodiscard]] uint32_t triangleAt(uint32_t hitIndex) const
    {
        uint32_t list = 0;
        while (list < KindCount && hitIndex >= firstHit_[list + 1]) ++list;
        if (list == KindCount)
            list = uint32_t(std::upper_bound(firstHit_.begin() + KindCount, firstHit_.end(), hitIndex) -
                            firstHit_.begin()) -
                   1;
        return triangleOf(list, hitIndex - firstHit_[list]);
    }
    /// As Materials::coverageAt().
    [[nodiscard]] float coverageOfHit(uint32_t hitIndex, vec2 barycentric) const
    {
        const bool opaque = hitIndex < firstHit_[1];
        return opaque ? 1.0f : materials_.coverageAt(triangleAt(hitIndex), barycentric);
    }

    /// Triangles in all trees: those of a shared mesh count once.
    [[nodiscard]] uint32_t treeTriangleCount() const;
    /// Bytes of the lists.
    [[nodiscard]] std::size_t byteCount() const;
    /// Offset of ray origins along the normal. It grows with the coordinates, so it exceeds their rounding error.
    [[nodiscard]] float epsilonAt(vec3 position) const { return shading::rayEpsilon(position, sceneScale_); }
    /// Diagonal of the bounds of all that rays can hit, in metres.
    [[nodiscard]] float sceneScale() const { return sceneScale_; }
    [[nodiscard]] vec3 rayOrigin(const SurfacePoint& point) const
    {
        return point.position + point.geometricNormal * epsilonAt(point.position);
    }

private:
    const BakeGeometry& geometry_;
    Materials materials_;
    MeshTrees meshTrees_;
    std::array<std::vector<uint32_t>, KindCount> trianglesOfKind_;
    std::vector<uint32_t> firstHit_; ///< by list, hit index of its first triangle; then their number
    float sceneScale_ = 1.0f;
    bool anyBlended_ = false;
    bool anyTinted_ = false;
};

} // namespace halflight
