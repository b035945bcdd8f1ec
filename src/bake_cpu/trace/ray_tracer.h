#pragma once
// What a ray needs to know of the scene's materials, and the tracer that finds hits: Embree and textures in one place.

#include "bake_cpu/trace/embree.h"

#include "halflight/bake/integrator.h"
#include "halflight/base/image.h"
#include "halflight/base/math.h"
#include "halflight/scene/scene.h"

#include <array>
#include <memory>
#include <vector>

namespace halflight {

/// A material as light transport sees it.
struct TransportMaterial {
    vec3 baseColorFactor{0.0f};
    float opacity = 1.0f; ///< base colour alpha
    vec3 emission{0.0f};  ///< nits
    TextureRef baseColor;
    TextureRef metallicRoughness; ///< B channel scales metallic, G roughness
    float metallicFactor = 0.0f;
    float roughnessFactor = 1.0f;
    float specular = 1.0f; ///< KHR_materials_specular's factor
    TextureRef emissive;
    Material::AlphaMode alphaMode = Material::AlphaMode::Opaque;
    float alphaCutoff = 0.5f;
    bool doubleSided = false;
    bool unlit = false;
};

/// The nearest surface along a ray, before anybody looks at what is there.
struct RayHit {
    bool found = false;
    bool behind = false; ///< the back of the triangle, whatever it is
    uint32_t geomID = 0;
    uint32_t primID = 0;
    vec2 barycentric{0.0f};
    float distance = 0.0f;
};

/// Parameters of the BRDF at one point (shading/brdf.h).
struct SurfaceReflectance {
    vec3 baseColor{0.0f}; ///< 0…1
    float metallic = 0.0f;
    float roughness = 1.0f;
    float specular = 1.0f;
};

/// What is at a ray's end. Back faces of single-sided and solid surfaces reflect like front faces but do not emit.
struct SurfaceHit {
    float distance = 0.0f;
    const TransportMaterial* material = nullptr;
    SurfacePoint point; ///< normals face the ray's origin
    vec3 albedo{0.0f};
    vec3 emission{0.0f};
};

/// Embree scene over flattened geometry. Immutable after construction; all queries are thread-safe.
class RayTracer {
public:
    /// `geometry` and `scene` outlive the tracer. `device`: what rtcNewDevice() takes; null for this processor's best.
    /// `tree`: by default one that takes three times as long to build as Embree's own default; rays are many, and well
    /// worth it.
    RayTracer(const Scene& scene, const BakeGeometry& geometry, const char* device = nullptr,
              RTCBuildQuality tree = RTC_BUILD_QUALITY_HIGH);
    ~RayTracer();
    RayTracer(const RayTracer&) = delete;
    RayTracer& operator=(const RayTracer&) = delete;

    /// Nearest surface along a unit direction. Camera rays pass through back faces of single-sided surfaces, as the
    /// renderer does, and see objects that cast no shadow.
    [[nodiscard]] RayHit nearest(vec3 origin, vec3 direction, float tMin, float tMax, bool cameraRay = false) const;
    /// Whether anything that casts shadows lies between. Both faces of every surface block.
    [[nodiscard]] bool occluded(vec3 origin, vec3 direction, float tMin, float tMax) const;
    /// What of the light along a ray arrives: 0 where anything opaque lies between, dimmed by what blended surfaces
    /// cover.
    [[nodiscard]] float transmittance(vec3 origin, vec3 direction, float tMin, float tMax) const;

    /// The same for eight rays at once, without looking at what they hit: fill `rays` (see clear()), read hit.geomID,
    /// primID, u, v, Ng and ray.tfar; a blocked shadow ray has a negative tfar.
    void intersect(const embree::LaneMask& valid, RTCRayHit8& rays) const;
    void occluded(const embree::LaneMask& valid, RTCRay8& rays) const;
    [[nodiscard]] std::array<float, embree::kPacket> transmittance(const embree::LaneMask& valid, RTCRay8& rays) const;
    /// Sets what all rays of a packet share.
    static void clear(RTCRay8& rays);

    /// Number of the triangle that a hit names, and its place among all hit triangles, 0 … hitTriangleCount() - 1.
    [[nodiscard]] uint32_t triangleOf(uint32_t geomID, uint32_t primID) const
    {
        return trianglesOfGeometry_[geomID][primID];
    }
    [[nodiscard]] uint32_t hitIndex(uint32_t geomID, uint32_t primID) const { return firstHit_[geomID] + primID; }
    [[nodiscard]] uint32_t hitTriangleCount() const { return firstHit_.back(); }
    [[nodiscard]] uint32_t triangleAt(uint32_t hitIndex) const;
    /// What is at the end of a ray that hit something.
    [[nodiscard]] SurfaceHit surfaceAt(const RayHit& at) const;
    [[nodiscard]] SurfaceReflectance reflectanceAt(uint32_t triangle, vec2 barycentric) const;
    /// Diffuse albedo that carries light on (shading::transportAlbedo()), 0…1.
    [[nodiscard]] vec3 albedoAt(uint32_t triangle, vec2 barycentric) const;
    /// Whether the back of a triangle is a place nobody is meant to see: inside a solid, or behind a single side.
    [[nodiscard]] bool backIsHidden(uint32_t triangle) const
    {
        return geometry_.solid[triangle] != 0 || !materialOfTriangle(triangle).doubleSided;
    }
    /// Whether a ray ended at such a back.
    [[nodiscard]] bool metHiddenBack(const RayHit& at) const
    {
        return at.found && at.behind && backIsHidden(triangleOf(at.geomID, at.primID));
    }

    /// What a ray crosses on its way out of the scene.
    struct Crossings {
        int solidsLeft = 0; ///< closed objects left minus those entered: > 0 when the origin is inside one
        int rays = 0;
    };
    [[nodiscard]] Crossings crossings(vec3 origin, vec3 direction) const;

    [[nodiscard]] const TransportMaterial& materialOfTriangle(uint32_t triangle) const;
    [[nodiscard]] vec3 emissionAt(uint32_t triangle, vec2 barycentric) const;
    /// Share of rays that meet the surface there: 1 opaque, 0 or 1 masked, alpha blended.
    [[nodiscard]] float coverageAt(uint32_t triangle, vec2 barycentric) const;
    [[nodiscard]] float coverageOfHit(uint32_t hitIndex, vec2 barycentric) const
    {
        const bool opaque = hitIndex < firstHit_[1];
        return opaque ? 1.0f : coverageAt(triangleAt(hitIndex), barycentric);
    }
    [[nodiscard]] const BakeGeometry& geometry() const { return geometry_; }
    [[nodiscard]] bool ok() const { return scene_ != nullptr; }

    /// Distance by which ray origins leave their surface: grows with the coordinates' size, so that it exceeds their
    /// rounding error.
    [[nodiscard]] float epsilonAt(vec3 position) const;

private:
    struct GeometryUser;
    bool occluded(embree::RayContext& context, vec3 origin, vec3 direction, float tMin, float tMax) const;
    void occluded(embree::RayContext& context, const embree::LaneMask& valid, RTCRay8& rays) const;
    static void filter(const RTCFilterFunctionNArguments* arguments);
    [[nodiscard]] bool passes(uint32_t triangle, vec2 barycentric, const float* rayBits) const;
    [[nodiscard]] bool passesBlended(uint32_t triangle, vec2 barycentric, embree::BlendedTransmittance& ray) const;
    [[nodiscard]] vec2 textureCoordinate(uint32_t triangle, vec2 barycentric, const TextureRef& ref) const;
    [[nodiscard]] float alphaAt(uint32_t triangle, vec2 barycentric, const TransportMaterial& material) const;

    const BakeGeometry& geometry_;
    std::vector<TransportMaterial> materials_; ///< the last one is glTF's default material
    /// Textures shrunk to at most 256 texels a side (in linear light): diffuse transport needs no more, caches like it.
    std::vector<ImageRgba8> smallTextures_;
    const Scene& sceneData_;
    std::vector<std::vector<uint32_t>> trianglesOfGeometry_;
    std::vector<uint32_t> firstHit_; ///< by geometry, hit triangles before it; at the end, all of them
    std::vector<std::unique_ptr<GeometryUser>> users_;
    RTCDevice device_ = nullptr;
    bool packets_ = false; ///< eight rays at once are faster than one by one
    RTCScene scene_ = nullptr;
    float sceneScale_ = 1.0f;
    bool anyBlended_ = false; ///< there is something that dims rays
};

} // namespace halflight
