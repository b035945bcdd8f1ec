#pragma once
// Rays against the scene: the nearest hit, transmittance along a ray, and the surface at a hit.

#include "bake_cpu/trace/embree_bytes.h"
#include "bake_cpu/trace/materials.h"
#include "bake_cpu/trace/mesh_trees.h"
#include "bake_cpu/trace/ray_packet.h"

#include <array>
#include <memory>
#include <span>
#include <vector>

namespace halflight {

/// One side of a triangle that rays can hit.
struct FaceId {
    uint32_t hitIndex : 31 = 0; ///< as RayTracer::hitIndex()
    uint32_t back : 1 = 0;
};
static_assert(sizeof(FaceId) == 4);

/// The nearest hit along a ray, without the properties of the surface there.
struct RayHit {
    bool found = false;
    bool back = false;   ///< the hit is on the back of the triangle
    uint32_t geomID = 0; ///< as RayTracer::intersect()
    uint32_t primID = 0;
    vec2 barycentric{0.0f};
    float distance = 0.0f;
};

/// The surface at a hit. Hidden backs (Materials::backIsHidden()) reflect like fronts and emit nothing.
struct SurfaceHit {
    float distance = 0.0f;
    const TransportMaterial* material = nullptr;
    SurfacePoint point; ///< normals face the ray's origin
    SurfaceReflectance reflectance;
    vec3 emission{0.0f};
};

/// Embree scene over the geometry: a tree of the triangles that are stored in world space, and of the instances of
/// shared meshes, each of which has a tree of its own. Immutable after construction; all queries are thread-safe.
class RayTracer {
public:
    /// `geometry` and `scene` outlive the tracer. `tree`: the default takes three times as long to build as Embree's
    /// own default, and its rays are faster; a bake traces enough rays to gain from it.
    RayTracer(const Scene& scene, const BakeGeometry& geometry, InstructionSet isa = InstructionSet::Automatic,
              RTCBuildQuality tree = RTC_BUILD_QUALITY_HIGH);
    ~RayTracer();
    RayTracer(const RayTracer&) = delete;
    RayTracer& operator=(const RayTracer&) = delete;

    [[nodiscard]] bool ok() const { return scene_ != nullptr; }
    [[nodiscard]] const BakeGeometry& geometry() const { return geometry_; }
    [[nodiscard]] const Materials& materials() const { return materials_; }

    /// Nearest surface along a unit direction. Camera rays pass through backs of single-sided surfaces, as the renderer
    /// does, and hit objects that cast no shadow.
    [[nodiscard]] RayHit nearest(vec3 origin, vec3 direction, float tMin, float tMax, bool cameraRay = false) const;
    /// Whether any shadow caster lies between. Both sides of every surface occlude.
    [[nodiscard]] bool occluded(vec3 origin, vec3 direction, float tMin, float tMax) const;
    /// Fraction of light that passes along a ray: 0 behind an opaque surface, else the product of 1 - alpha of the
    /// blended surfaces.
    [[nodiscard]] float transmittance(vec3 origin, vec3 direction, float tMin, float tMax) const;

    /// The same for packets. The caller fills `rays` after embree::clear() and reads hit.geomID, primID, u, v, Ng and
    /// ray.tfar; the tfar of an occluded ray is negative. u, v and Ng are those of the triangle in the world, in
    /// instances too. geomID is a kind of geometry, or KindCount plus the index of an instance, whose primID is an
    /// index into MeshTree::triangles.
    void intersect(const embree::LaneMask& valid, RTCRayHit8& rays) const;
    void occluded(const embree::LaneMask& valid, RTCRay8& rays) const;
    [[nodiscard]] std::array<float, embree::kPacket> transmittance(const embree::LaneMask& valid, RTCRay8& rays) const;

    /// Shadow casters whose bounds are within a distance of a point, some of them more than once, and perhaps others
    /// near it. False if there are more than `most`.
    bool trianglesNear(vec3 center, float radius, std::size_t most, std::vector<uint32_t>& triangles) const;

    /// A hit's triangle, as BakeGeometry counts them.
    [[nodiscard]] uint32_t triangleOf(uint32_t geomID, uint32_t primID) const
    {
        return geomID < KindCount ? trianglesOfKind_[geomID][primID]
                                  : meshTrees_.triangleOf(meshTrees_.instances[geomID - KindCount], primID);
    }
    /// Index of a hit's triangle among all triangles in the ray-tracing tree, 0 … hitTriangleCount() - 1.
    [[nodiscard]] uint32_t hitIndex(uint32_t geomID, uint32_t primID) const { return firstHit_[geomID] + primID; }
    [[nodiscard]] uint32_t hitTriangleCount() const { return firstHit_.back(); }
    [[nodiscard]] uint32_t triangleAt(uint32_t hitIndex) const;
    [[nodiscard]] FaceId faceOf(const RayHit& at) const { return {hitIndex(at.geomID, at.primID), at.back ? 1u : 0u}; }
    [[nodiscard]] FaceId faceOf(const RTCRayHit8& rays, int lane) const
    {
        return {hitIndex(rays.hit.geomID[lane], rays.hit.primID[lane]), embree::hitBack(rays, lane) ? 1u : 0u};
    }

    /// `at.found` is true.
    [[nodiscard]] SurfaceHit surfaceAt(const RayHit& at) const;
    [[nodiscard]] bool hitHiddenBack(const RayHit& at) const
    {
        return at.found && at.back && materials_.backIsHidden(triangleOf(at.geomID, at.primID));
    }
    /// As Materials::coverageAt().
    [[nodiscard]] float coverageOfHit(uint32_t hitIndex, vec2 barycentric) const
    {
        const bool opaque = hitIndex < firstHit_[1];
        return opaque ? 1.0f : materials_.coverageAt(triangleAt(hitIndex), barycentric);
    }

    /// Solids that a ray leaves on its way out of the scene, minus those that it enters; above 0, the origin is inside
    /// one. All surfaces count, however near to one another: solids may share a face. 0 for a ray through very many.
    [[nodiscard]] int solidsLeft(vec3 origin, vec3 direction) const;

    /// Triangles in all trees: those of a shared mesh count once.
    [[nodiscard]] uint32_t treeTriangleCount() const;
    /// Most bytes so far of Embree's trees, and of the lists that lead from hits to triangles.
    [[nodiscard]] std::size_t peakBytes() const;

    /// Offset of ray origins along the normal. It grows with the coordinates, so it exceeds their rounding error.
    [[nodiscard]] float epsilonAt(vec3 position) const;

private:
    struct GeometryUser;
    void sortTriangles();
    bool build(RTCScene scene, RTCBuildQuality quality);
    bool attach(RTCScene scene, GeometryKind kind, std::span<const uint32_t> triangles, const MeshTree* tree);
    bool setVertices(RTCGeometry mesh) const;
    bool setIndices(RTCGeometry mesh, std::span<const uint32_t> triangles, const MeshTree* tree) const;
    void attachInstances(RTCScene scene);
    void intersect(embree::RayContext& context, RTCRayHit& ray) const;
    /// Makes a hit of an instance one of a triangle in the world.
    void toWorld(RTCHit& hit) const;
    void preferFront(vec3 origin, vec3 direction, RTCHit& hit, float& distance) const;
    bool occluded(embree::RayContext& context, vec3 origin, vec3 direction, float tMin, float tMax) const;
    void occluded(embree::RayContext& context, const embree::LaneMask& valid, RTCRay8& rays) const;
    static void filter(const RTCFilterFunctionNArguments* arguments);
    static void countSolids(const RTCFilterFunctionNArguments* arguments);
    static void passHiddenBacks(const RTCFilterFunctionNArguments* arguments);
    [[nodiscard]] bool passes(uint32_t triangle, vec2 barycentric, const float* rayBits) const;
    [[nodiscard]] bool passesBlended(uint32_t triangle, vec2 barycentric, embree::BlendedTransmittance& ray) const;

    const BakeGeometry& geometry_;
    Materials materials_;
    MeshTrees meshTrees_;
    std::array<std::vector<uint32_t>, KindCount> trianglesOfKind_; ///< stored in world space
    std::vector<uint32_t> firstHit_; ///< by geomID, hit index of its first triangle; then their number
    embree::DeviceBytes embreeBytes_;
    std::vector<std::unique_ptr<GeometryUser>> users_;
    RTCDevice device_ = nullptr;
    bool packets_ = false; ///< the device has instructions for packets
    RTCScene scene_ = nullptr;
    float sceneScale_ = 1.0f;
    bool anyBlended_ = false;
};

/// User data of an Embree geometry, for the filter function.
struct RayTracer::GeometryUser {
    const RayTracer* tracer = nullptr;
    std::span<const uint32_t> triangles; ///< in the tree of a mesh, counted from the first of the object
    bool castShadows = true;

    /// A triangle of the bake, and the instance that it is of, or null.
    [[nodiscard]] uint32_t triangle(unsigned instID, unsigned primID, const BakeGeometry::Instance*& place) const
    {
        place = nullptr;
        if (instID == RTC_INVALID_GEOMETRY_ID) return triangles[primID];
        const MeshTrees::Instance& instance = tracer->meshTrees_.instances[instID - KindCount];
        place = instance.place;
        return instance.firstTriangle + triangles[primID];
    }
    /// The same of a hit that a filter function sees, and whether the ray meets the triangle's back.
    uint32_t triangle(const RTCFilterFunctionNArguments* arguments, unsigned lane, bool& back) const
    {
        const unsigned count = arguments->N;
        const float along = RTCHitN_Ng_x(arguments->hit, count, lane) * RTCRayN_dir_x(arguments->ray, count, lane) +
                            RTCHitN_Ng_y(arguments->hit, count, lane) * RTCRayN_dir_y(arguments->ray, count, lane) +
                            RTCHitN_Ng_z(arguments->hit, count, lane) * RTCRayN_dir_z(arguments->ray, count, lane);
        const BakeGeometry::Instance* place = nullptr;
        const uint32_t found = triangle(RTCHitN_instID(arguments->hit, count, lane, 0),
                                        RTCHitN_primID(arguments->hit, count, lane), place);
        back = (along > 0.0f) != (place != nullptr && place->mirrored);
        return found;
    }
};

} // namespace halflight
