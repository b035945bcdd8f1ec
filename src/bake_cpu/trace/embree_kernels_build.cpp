// Fills Embree's trees with the scene's triangles and the instances of shared meshes.
#include "bake_cpu/trace/embree_kernels.h"

#include "bake_cpu/trace/embree_device.h"

#include "halflight/base/parallel.h"

#include <algorithm>
#include <array>
#include <utility>

namespace halflight {

EmbreeKernels::EmbreeKernels(const RayScene& scene, InstructionSet isa, RTCBuildQuality quality) : scene_(scene)
{
    device_ = embree::openDevice(isa);
    if (device_ == nullptr) return;
    embreeBytes_.watch(device_);
    packets_ = embree::takesPackets(device_);
    RTCScene tree = rtcNewScene(device_);
    if (build(tree, quality)) {
        tree_ = tree;
    } else {
        rtcReleaseScene(tree);
    }
}

EmbreeKernels::~EmbreeKernels()
{
    if (tree_ != nullptr) rtcReleaseScene(tree_);
    for (RTCScene tree : meshTrees_) rtcReleaseScene(tree);
    if (device_ != nullptr) rtcReleaseDevice(device_);
}

std::string EmbreeKernels::describe(const std::string& method) const
{
    const int threads = threadCount();
    return "cpu (" + method + ", Embree " + RTC_VERSION_STRING + ", " + std::to_string(threads) +
           (threads == 1 ? " thread)" : " threads)");
}

MakeKernels embreeKernels(InstructionSet isa, RTCBuildQuality quality)
{
    return [=](const RayScene& scene) -> std::unique_ptr<RayKernels> {
        auto kernels = std::make_unique<EmbreeKernels>(scene, isa, quality);
        return kernels->ok() ? std::move(kernels) : nullptr;
    };
}

/// Fills the scene and the trees of shared meshes. False when memory ran out.
bool EmbreeKernels::build(RTCScene tree, RTCBuildQuality quality)
{
    rtcSetSceneBuildQuality(tree, quality);
    rtcSetSceneFlags(tree, embree::kRaysMayFilter);
    for (uint32_t kind = 0; kind < KindCount; ++kind) {
        if (!attach(tree, GeometryKind(kind), scene_.trianglesOf(GeometryKind(kind)), nullptr)) return false;
    }
    for (const MeshTree& mesh : scene_.meshTrees().trees) {
        RTCScene own = meshTrees_.emplace_back(rtcNewScene(device_));
        rtcSetSceneBuildQuality(own, quality);
        rtcSetSceneFlags(own, RTCSceneFlags(RTC_SCENE_FLAG_COMPACT | embree::kRaysMayFilter));
        for (uint32_t kind = 0; kind < KindCount; ++kind) {
            const auto triangles =
                std::span<const uint32_t>(mesh.triangles)
                    .subspan(mesh.firstOfKind[kind], mesh.firstOfKind[kind + 1] - mesh.firstOfKind[kind]);
            if (!attach(own, GeometryKind(kind), triangles, &mesh)) return false;
        }
        rtcCommitScene(own);
    }
    attachInstances(tree);
    rtcCommitScene(tree);
    return true;
}

/// Embree reads the geometry's positions, or a copy where nothing lies behind the last one: it reads 16 bytes at each.
bool EmbreeKernels::setVertices(RTCGeometry mesh) const
{
    const std::vector<vec3>& positions = scene_.geometry().positions;
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
bool EmbreeKernels::setIndices(RTCGeometry mesh, std::span<const uint32_t> triangles, const MeshTree* tree) const
{
    const auto storedOf = [&](uint32_t triangle) {
        return tree != nullptr ? scene_.geometry().parts[tree->firstPart].firstStored + triangle
                               : scene_.geometry().storedOf(triangle).index;
    };
    const uint32_t first = storedOf(triangles.front());
    std::size_t adjacent = 1;
    while (adjacent < triangles.size() && storedOf(triangles[adjacent]) == first + adjacent) ++adjacent;
    if (adjacent == triangles.size()) {
        rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, scene_.geometry().triangles.data(),
                                   first * sizeof(uvec3), sizeof(uvec3), triangles.size());
        return true;
    }
    auto* copy = static_cast<uvec3*>(
        rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, sizeof(uvec3), triangles.size()));
    if (copy == nullptr) return false;
    for (std::size_t i = 0; i < triangles.size(); ++i) copy[i] = scene_.geometry().triangles[storedOf(triangles[i])];
    return true;
}

/// Attaches the triangles of one kind, if there are any: of the scene's own tree (`mesh` null), or of a mesh's. False
/// when memory ran out.
bool EmbreeKernels::attach(RTCScene tree, GeometryKind kind, std::span<const uint32_t> triangles, const MeshTree* mesh)
{
    if (triangles.empty()) return true;
    RTCGeometry made = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    if (!setVertices(made) || !setIndices(made, triangles, mesh)) {
        rtcReleaseGeometry(made);
        return false;
    }
    users_.push_back(std::make_unique<GeometryUser>(GeometryUser{this, triangles, kind != NoShadow}));
    rtcSetGeometryUserData(made, users_.back().get());
    if (kind != Opaque) {
        rtcSetGeometryIntersectFilterFunction(made, filter);
        rtcSetGeometryOccludedFilterFunction(made, filter);
    }
    rtcCommitGeometry(made);
    rtcAttachGeometryByID(tree, made, unsigned(kind));
    rtcReleaseGeometry(made);
    return true;
}

void EmbreeKernels::attachInstances(RTCScene tree)
{
    unsigned id = KindCount;
    for (const MeshTrees::Instance& instance : scene_.meshTrees().instances) {
        RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_INSTANCE);
        rtcSetGeometryInstancedScene(geometry, meshTrees_[instance.tree]);
        const mat3& linear = instance.place->linear;
        const std::array<vec3, 4> columns{linear[0], linear[1], linear[2], instance.place->origin};
        rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, columns.data());
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(tree, geometry, id++);
        rtcReleaseGeometry(geometry);
    }
}

} // namespace halflight
