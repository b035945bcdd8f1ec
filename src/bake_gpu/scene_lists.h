#pragma once
// What a device needs of a scene, as plain lists.

#include "bake_gpu/glass_lists.h"
#include "transport/trace/ray_scene.h"

#include <map>
#include <vector>

namespace halflight {

/// Lists for trees and shaders. Objects that cast no shadow are not in them: only rays of cameras hit those.
struct SceneLists {
    explicit SceneLists(const RayScene& scene);

    struct Geometry {
        bool opaque = false;
        std::vector<uvec3> corners; ///< stored vertices
    };
    /// What one tree of triangles holds: those in world space, or a shared mesh's.
    struct Mesh {
        std::vector<Geometry> geometries;
    };
    struct Instance {
        uint32_t mesh = 0;
        uint32_t firstSlot = 0; ///< of its first geometry
        const BakeGeometry::Instance* place = nullptr;
    };
    std::vector<Mesh> meshes;
    std::vector<Instance> instances;
    std::vector<shading::GpuSlot> slots; ///< by instance and geometry
    /// Of what rays do not hit: where its masks are, for samples of emitters. No tree has them.
    std::vector<shading::GpuSlot> unseen;
    std::vector<uint8_t> faces; ///< kFace… of all triangles of the meshes
    std::vector<shading::GpuMaskedTriangle> masked;
    std::vector<shading::GpuMask> masks;
    std::vector<shading::GpuBytes> pictures;
    std::vector<uint8_t> texels;
    GlassLists glass;

private:
    /// First face and first masked triangle of a geometry.
    struct Place {
        uint32_t face = 0;
        uint32_t masked = shading::kNone;
    };
    Place addGeometry(Mesh& mesh, GeometryKind kind, std::span<const uint32_t> triangles, uint32_t first);
    void addUnseen(uint32_t firstHit, std::span<const uint32_t> triangles, uint32_t first);
    shading::GpuMaskedTriangle maskedTriangle(uint32_t triangle, uint32_t first);
    uint32_t maskOf(const TransportMaterial& material);
    uint32_t tintOf(const TransportMaterial& material);
    shading::GpuTextureUse useOf(const TextureRef& ref, int channel, int firstSet);
    int pictureOf(int texture, int channel);

    const RayScene& scene_;
    std::map<const TransportMaterial*, uint32_t> maskNumbers_;
    std::map<std::pair<int, int>, int> pictureNumbers_; ///< by texture and channel
};

} // namespace halflight
