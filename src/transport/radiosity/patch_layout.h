#pragma once
// Radiosity patches of hit surfaces: from a hit to its patch and element.

#include "transport/trace/ray_tracer.h"

#include "halflight/shading/patches.h"

#include <cstdint>
#include <vector>

namespace halflight {

/// Index of a patch or element: fronts of chart patches, their backs, small triangles (front and back of each in turn),
/// elements.
using PatchId = uint32_t;
constexpr PatchId kNoPatch = ~0u;
constexpr PatchId kMaxPatches = 0x1fffffffu;

/// A chart patch is a square of 1, 4, 16 or 64 lightmap texels on one chart that faces one of six axes. Small triangles
/// without a lightmap are patches too. Both sides of each are patches. Elements subdivide a patch (Cohen, Greenberg,
/// Immel and Brock 1986, "An Efficient Radiosity Approach for Realistic Image Synthesis").
struct PatchLayout {
    /// Patches of a hit triangle's front: a rectangle, row by row. Texture coordinates are in patches from its corner.
    struct Surface {
        vec2 origin{0.0f};
        vec2 edgeU{0.0f};
        vec2 edgeV{0.0f};
        uint32_t firstPatch : 29 = 0;
        uint32_t hasPatches : 1 = 0;
        uint32_t emissive : 1 = 0;
        uint16_t width = 0;
        uint16_t height = 0;
    };
    static_assert(sizeof(Surface) == 32);
    /// Elements of a patch, row by row.
    struct Elements {
        uint32_t first : 30 = 0;
        uint32_t halfTexel : 1 = 0; ///< width: half a texel, else a texel
        uint32_t split : 1 = 0;     ///< 0 = the patch has no elements
    };

    std::vector<Surface> surfaces;            ///< by hit index
    std::vector<Elements> elements;           ///< by patch
    std::vector<uint32_t> hitIndexOfTriangle; ///< ~0 = rays do not hit the triangle
    int patchShift = 0;                       ///< a chart patch is 2^shift texels wide
    float texelMeters = 0.0f;                 ///< mean width of a texel
    uint32_t chartPatches = 0;                ///< number of fronts of chart patches, and of their backs

    template<typename Archive> void archive(Archive& a)
    {
        a(surfaces, elements, hitIndexOfTriangle, patchShift, texelMeters, chartPatches);
    }
    /// Patches without elements.
    [[nodiscard]] uint32_t patchCount() const { return uint32_t(elements.size()); }
    [[nodiscard]] const Surface& surface(FaceId face) const { return surfaces[face.hitIndex]; }
    [[nodiscard]] bool hasPatches(FaceId face) const { return surface(face).hasPatches != 0; }
    [[nodiscard]] bool emissive(FaceId face) const { return surface(face).emissive != 0; }
    /// Front or back of a triangle; false if rays do not hit it.
    [[nodiscard]] bool faceOf(uint32_t triangle, bool back, FaceId& face) const
    {
        const uint32_t index = hitIndexOfTriangle[triangle];
        if (index == ~0u) return false;
        face = {index, back ? 1u : 0u};
        return true;
    }

    /// Patch at a point of a face that has patches.
    [[nodiscard]] PatchId patchAt(FaceId face, vec2 barycentric) const
    {
        const Surface& s = surface(face);
        const vec2 at = s.origin + barycentric.x * s.edgeU + barycentric.y * s.edgeV;
        const PatchId front = s.firstPatch + shading::patchNumberAt(at, s.width, s.height);
        return face.back == 0 ? front : backOf(front);
    }
    [[nodiscard]] PatchId backOf(PatchId front) const { return front + (front < chartPatches ? chartPatches : 1); }
    /// Element of a patch at a point, or kNoPatch.
    [[nodiscard]] PatchId elementAt(FaceId face, vec2 barycentric, PatchId patch) const;
    /// Width of a patch is 2^shift elements.
    [[nodiscard]] int elementShift(PatchId patch) const
    {
        return patchShift + (elements[patch].halfTexel != 0 ? 1 : 0);
    }
    [[nodiscard]] uint32_t elementCount(PatchId patch) const { return 1u << (2 * elementShift(patch)); }
};

} // namespace halflight
