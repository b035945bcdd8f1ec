#pragma once
// Embree behind RayKernels.

#include "bake_cpu/trace/embree_bytes.h"
#include "transport/trace/ray_kernels.h"

namespace halflight {

/// A tree of the triangles that are stored in world space, and of the instances of shared meshes, each of which has a
/// tree of its own. A batch of one ray is traced alone, others in packets of eight.
class EmbreeKernels final : public RayKernels {
public:
    /// `scene` outlives the kernels.
    EmbreeKernels(const RayScene& scene, InstructionSet isa, RTCBuildQuality quality);
    ~EmbreeKernels() override;
    EmbreeKernels(const EmbreeKernels&) = delete;
    EmbreeKernels& operator=(const EmbreeKernels&) = delete;

    [[nodiscard]] bool ok() const { return tree_ != nullptr; }

    Status nearest(std::span<const Ray> rays, std::span<RayHit> out, RayUse use) const override;
    Status occluded(std::span<const Ray> rays, std::span<bool> out) const override;
    Status transmittance(std::span<const Ray> rays, std::span<vec3> out) const override;
    Status crossings(std::span<const Ray> rays, std::span<int> out) const override;
    bool trianglesNear(vec3 center, float radius, std::size_t most, std::vector<uint32_t>& triangles) const override;
    [[nodiscard]] std::string describe(const std::string& method) const override;
    [[nodiscard]] std::size_t peakBytes() const override { return embreeBytes_.most(); }

private:
    struct GeometryUser;
    bool build(RTCScene tree, RTCBuildQuality quality);
    bool attach(RTCScene tree, GeometryKind kind, std::span<const uint32_t> triangles, const MeshTree* mesh);
    bool setVertices(RTCGeometry mesh) const;
    bool setIndices(RTCGeometry mesh, std::span<const uint32_t> triangles, const MeshTree* tree) const;
    void attachInstances(RTCScene tree);

    [[nodiscard]] RayHit nearest(const Ray& ray, RayUse use) const;
    void nearestOfPacket(std::span<const Ray> rays, std::span<RayHit> out) const;
    [[nodiscard]] bool occluded(const Ray& ray, embree::RayContext& context) const;
    void coloredTransmittance(std::span<const Ray> rays, std::span<vec3> out) const;
    [[nodiscard]] RayHit hitOf(const RTCHit& hit, vec3 direction, float distance) const;
    void toWorld(RTCHit& hit) const;
    void preferFront(vec3 origin, vec3 direction, RTCHit& hit, float& distance) const;

    static void filter(const RTCFilterFunctionNArguments* arguments);
    static bool passesGlass(const RTCFilterFunctionNArguments* arguments, unsigned lane, uint32_t triangle,
                            vec2 barycentric, const BakeGeometry::Instance* place);
    static void countSolids(const RTCFilterFunctionNArguments* arguments);
    static void passHiddenBacks(const RTCFilterFunctionNArguments* arguments);
    [[nodiscard]] bool passes(uint32_t triangle, vec2 barycentric, const float* rayBits) const;
    [[nodiscard]] bool passesBlended(uint32_t triangle, vec2 barycentric, embree::BlendedTransmittance& ray) const;

    const RayScene& scene_;
    embree::DeviceBytes embreeBytes_;
    std::vector<std::unique_ptr<GeometryUser>> users_;
    RTCDevice device_ = nullptr;
    bool packets_ = false; ///< the device has instructions for packets
    RTCScene tree_ = nullptr;
    std::vector<RTCScene> meshTrees_; ///< as RayScene::meshTrees()
};

/// User data of an Embree geometry, for the filter function.
struct EmbreeKernels::GeometryUser {
    const EmbreeKernels* kernels = nullptr;
    std::span<const uint32_t> triangles; ///< in the tree of a mesh, counted from the first of the object
    bool castShadows = true;

    /// A triangle of the bake, and the instance that it is of, or null.
    [[nodiscard]] uint32_t triangle(unsigned instID, unsigned primID, const BakeGeometry::Instance*& place) const
    {
        place = nullptr;
        if (instID == RTC_INVALID_GEOMETRY_ID) return triangles[primID];
        const MeshTrees::Instance& instance = kernels->scene_.meshTrees().instances[instID - KindCount];
        place = instance.place;
        return instance.firstTriangle + triangles[primID];
    }
    /// The same of a hit that a filter function sees, and whether the ray meets the triangle's back. Both are in the
    /// mesh's space, whose fronts are counter-clockwise, mirrored or not.
    uint32_t triangle(const RTCFilterFunctionNArguments* arguments, unsigned lane, bool& back) const
    {
        const unsigned count = arguments->N;
        const float along = RTCHitN_Ng_x(arguments->hit, count, lane) * RTCRayN_dir_x(arguments->ray, count, lane) +
                            RTCHitN_Ng_y(arguments->hit, count, lane) * RTCRayN_dir_y(arguments->ray, count, lane) +
                            RTCHitN_Ng_z(arguments->hit, count, lane) * RTCRayN_dir_z(arguments->ray, count, lane);
        const BakeGeometry::Instance* place = nullptr;
        back = along > 0.0f;
        return triangle(RTCHitN_instID(arguments->hit, count, lane, 0), RTCHitN_primID(arguments->hit, count, lane),
                        place);
    }
};

/// The default tree takes three times as long to build as Embree's own default, and its rays are faster; a bake traces
/// enough rays to gain from it.
MakeKernels embreeKernels(InstructionSet isa = InstructionSet::Automatic,
                          RTCBuildQuality quality = RTC_BUILD_QUALITY_HIGH);

} // namespace halflight
