// Fills Embree's trees with the scene's triangles and the instances of shared meshes.
#include "bake_cpu/trace/ray_tracer.h"

#include <algorithm>
#include <array>
#include <utility>

namespace halflight {

void RayTracer::sortTriangles()
{
    Bounds bounds;
    for (const BakeGeometry::Part& part : geometry_.parts) {
        if (part.triangleCount == 0 || part.side == SurfaceSide::Back) continue;
        const TransportMaterial& material = materials_.of(part.firstTriangle);
        anyBlended_ = anyBlended_ || material.blended;
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

/// Fills the scene and the trees of shared meshes. False when memory ran out.
bool RayTracer::build(RTCScene scene, RTCBuildQuality quality)
{
    rtcSetSceneBuildQuality(scene, quality);
    rtcSetSceneFlags(scene, embree::kRaysMayFilter);
    for (uint32_t kind = 0; kind < KindCount; ++kind) {
        if (!attach(scene, GeometryKind(kind), trianglesOfKind_[kind], nullptr)) return false;
    }
    for (MeshTree& tree : meshTrees_.trees) {
        tree.scene = rtcNewScene(device_);
        rtcSetSceneBuildQuality(tree.scene, quality);
        rtcSetSceneFlags(tree.scene, RTCSceneFlags(RTC_SCENE_FLAG_COMPACT | embree::kRaysMayFilter));
        for (uint32_t kind = 0; kind < KindCount; ++kind) {
            const auto triangles =
                std::span<const uint32_t>(tree.triangles)
                    .subspan(tree.firstOfKind[kind], tree.firstOfKind[kind + 1] - tree.firstOfKind[kind]);
            if (!attach(tree.scene, GeometryKind(kind), triangles, &tree)) return false;
        }
        rtcCommitScene(tree.scene);
    }
    attachInstances(scene);
    rtcCommitScene(scene);
    return true;
}

/// Embree reads the geometry's positions, or a copy where nothing lies behind the last one: it reads 16 bytes at each.
bool RayTracer::setVertices(RTCGeometry mesh) const
{
    const std::vector<vec3>& positions = geometry_.positions;
    if (positions.capacity() > positions.size()) {
        rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, positions.data(), 0,
                                   sizeof(vec3), positions.size());
        return true;
    }
    void* copy =
        rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(vec3), positions.size());
    if (copy != nullptr) std::copy(positions.begin(), positions.end(), static_cast<vec3*>(copy));
    return copy != nullptr;
}

/// Embree reads the geometry's triangles, or a copy where others lie between them.
bool RayTracer::setIndices(RTCGeometry mesh, std::span<const uint32_t> triangles, const MeshTree* tree) const
{
    const auto storedOf = [&](uint32_t triangle) {
        return tree != nullptr ? geometry_.parts[tree->firstPart].firstStored + triangle
                               : geometry_.storedOf(triangle).index;
    };
    const uint32_t first = storedOf(triangles.front());
    std::size_t adjacent = 1;
    while (adjacent < triangles.size() && storedOf(triangles[adjacent]) == first + adjacent) ++adjacent;
    if (adjacent == triangles.size()) {
        rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, geometry_.triangles.data(),
                                   first * sizeof(uvec3), sizeof(uvec3), triangles.size());
        return true;
    }
    auto* copy = static_cast<uvec3*>(
        rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, sizeof(uvec3), triangles.size()));
    if (copy == nullptr) return false;
    for (std::size_t i = 0; i < triangles.size(); ++i) copy[i] = geometry_.triangles[storedOf(triangles[i])];
    return true;
}

/// Attaches the triangles of one kind, if there are any: of the scene's own tree (`tree` null), or of a mesh's. False
/// when memory ran out.
bool RayTracer::attach(RTCScene scene, GeometryKind kind, std::span<const uint32_t> triangles, const MeshTree* tree)
{
    if (triangles.empty()) return true;
    RTCGeometry mesh = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    if (!setVertices(mesh) || !setIndices(mesh, triangles, tree)) {
        rtcReleaseGeometry(mesh);
        return false;
    }
    users_.push_back(std::make_unique<GeometryUser>(GeometryUser{this, triangles, kind != NoShadow}));
    rtcSetGeometryUserData(mesh, users_.back().get());
    if (kind != Opaque) {
        rtcSetGeometryIntersectFilterFunction(mesh, filter);
        rtcSetGeometryOccludedFilterFunction(mesh, filter);
    }
    rtcCommitGeometry(mesh);
    rtcAttachGeometryByID(scene, mesh, unsigned(kind));
    rtcReleaseGeometry(mesh);
    return true;
}

void RayTracer::attachInstances(RTCScene scene)
{
    unsigned id = KindCount;
    for (const MeshTrees::Instance& instance : meshTrees_.instances) {
        RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_INSTANCE);
        rtcSetGeometryInstancedScene(geometry, meshTrees_.treeOf(instance).scene);
        const mat3& linear = instance.place->linear;
        const std::array<vec3, 4> columns{linear[0], linear[1], linear[2], instance.place->origin};
        rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, columns.data());
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(scene, geometry, id++);
        rtcReleaseGeometry(geometry);
    }
}

} // namespace halflight
