#pragma once
// The triangles of the scene's objects, in one list: rays hit them, texels lie on them.

#include "halflight/base/math.h"
#include "halflight/scene/scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace halflight {

/// Triangles are numbered through, in the order of `parts`: a *triangle* of the bake is such a number. What is stored
/// of a triangle is at another index: objects that share a mesh may share its stored triangles and vertices, and each
/// has an Instance that places them in the world. All other objects have stored triangles of their own, in world space.
/// Without instances both indices are equal. All values below by triangle are in world space, in metres.
struct BakeGeometry {
    static constexpr uint32_t kOwn = ~0u;

    /// One part of an object's mesh. Its triangles are [firstTriangle, firstTriangle + triangleCount). Parts of one
    /// object are adjacent.
    struct Part {
        int object = -1;   ///< index into Scene::objects
        int mesh = -1;     ///< index into Scene::meshes
        int part = -1;     ///< index into Mesh::parts
        int material = -1; ///< index into Scene::materials, -1 = default
        uint32_t firstTriangle = 0;
        uint32_t triangleCount = 0;
        uint32_t firstStored = 0;             ///< index of its first triangle among the stored ones
        uint32_t firstVertex = 0;             ///< of its stored vertices
        uint32_t vertexCount = 0;             ///< of its stored vertices
        uint32_t instance = kOwn;             ///< index into `instances`; kOwn: stored in world space
        SurfaceSide side = SurfaceSide::Both; ///< Back: rays do not meet its triangles, but those of the front half
        bool castShadows = true;
        bool receiveShadows = true; ///< false: lights are unoccluded
        int page = -1;              ///< lightmap page, -1 = none
    };
    /// Places the stored triangles of a shared mesh in the world. Their vertices are relative to the mesh's middle.
    struct Instance {
        mat3 linear{1.0f};          ///< world from mesh
        vec3 origin{0.0f};          ///< the mesh's middle in the world
        mat3 worldFromNormal{1.0f}; ///< up to scale; turns normals of mirrored triangles to their front
        vec2 texelScale{1.0f};      ///< texels of the page for a stored lightmap coordinate: scale * uv + offset
        vec2 texelOffset{0.0f};
        bool mirrored = false; ///< the stored winding is clockwise seen from the front

        [[nodiscard]] vec3 position(vec3 stored) const { return linear * stored + origin; }
        [[nodiscard]] vec3 normal(vec3 stored) const
        {
            const vec3 n = worldFromNormal * stored;
            const float length = glm::length(n);
            return length > 0.0f ? n / length : stored;
        }
        [[nodiscard]] vec2 texel(vec2 stored) const { return texelScale * stored + texelOffset; }
    };
    std::vector<Part> parts;
    std::vector<Instance> instances;
    // By stored triangle.
    std::vector<uvec3> triangles; ///< stored vertices; in world space counter-clockwise seen from the front
    std::vector<uint8_t> solid;   ///< 1: of a closed, outward-facing surface or a cavity in one; its back is inside
    std::vector<uint8_t> flipped; ///< 1: orientation repair reversed its winding; not for shared triangles
    std::vector<TexelSide> texelSides; ///< Front, FrontOfBoth or Mean; empty = all Front
    // By stored vertex.
    std::vector<vec3> positions;                     ///< metres
    std::vector<vec3> normals;                       ///< unit
    std::array<std::vector<vec2>, kTexCoordSets> uv; ///< zero where the part has none; empty where no part has any
    std::vector<vec4> colors;                        ///< linear; empty when no part has any
    std::vector<vec2> lightmapTexel; ///< in texels of the page, see Instance for shared ones; zero without lightmap

    /// Derived values by stored triangle; findFrames() computes them, and `partOfBlock`, from the above.
    struct Frame {
        vec3 normal{0.0f};        ///< unit, or zero; of a shared triangle in its mesh, by the stored winding
        float texelMeters = 0.0f; ///< see texelMeters(); not for shared triangles
    };
    std::vector<Frame> frames;
    std::vector<uint32_t> partOfBlock; ///< the part of every kBlock-th triangle, and of the last one
    void findFrames();

    [[nodiscard]] uint32_t triangleCount() const
    {
        return parts.empty() ? 0 : parts.back().firstTriangle + parts.back().triangleCount;
    }
    /// Index into `parts`.
    [[nodiscard]] uint32_t partNumberOf(uint32_t triangle) const
    {
        const uint32_t first = partOfBlock[triangle / kBlock];
        const uint32_t last = partOfBlock[triangle / kBlock + 1];
        if (first == last) return first;
        const auto isAfter = [](uint32_t t, const Part& part) { return t < part.firstTriangle; };
        const auto begin = parts.begin() + std::ptrdiff_t(first);
        const auto next = std::upper_bound(begin, parts.begin() + std::ptrdiff_t(last) + 1, triangle, isAfter);
        return uint32_t(next - parts.begin()) - 1;
    }
    [[nodiscard]] const Part& partOf(uint32_t triangle) const { return parts[partNumberOf(triangle)]; }

    /// What is stored of a triangle.
    struct Stored {
        uint32_t index = 0;
        const Instance* instance = nullptr; ///< null: in world space
    };
    [[nodiscard]] Stored storedOf(uint32_t triangle) const
    {
        if (instances.empty()) return {triangle, nullptr};
        const Part& part = partOf(triangle);
        return {part.firstStored + (triangle - part.firstTriangle),
                part.instance == kOwn ? nullptr : &instances[part.instance]};
    }
    /// Stored vertices, counter-clockwise seen from the front in the world.
    [[nodiscard]] uvec3 verticesOf(Stored stored) const
    {
        const uvec3 v = triangles[stored.index];
        return stored.instance != nullptr && stored.instance->mirrored ? uvec3(v.x, v.z, v.y) : v;
    }
    [[nodiscard]] uvec3 verticesOf(uint32_t triangle) const { return verticesOf(storedOf(triangle)); }
    /// Value of one stored vertex of a part, or of a triangle, in the world.
    [[nodiscard]] vec3 positionOf(const Part& part, uint32_t vertex) const
    {
        return part.instance == kOwn ? positions[vertex] : instances[part.instance].position(positions[vertex]);
    }
    [[nodiscard]] vec3 normalOf(const Part& part, uint32_t vertex) const
    {
        return part.instance == kOwn ? normals[vertex] : instances[part.instance].normal(normals[vertex]);
    }
    [[nodiscard]] vec2 texelOf(const Part& part, uint32_t vertex) const
    {
        return part.instance == kOwn ? lightmapTexel[vertex] : instances[part.instance].texel(lightmapTexel[vertex]);
    }
    [[nodiscard]] std::array<vec3, 3> cornersOf(uint32_t triangle) const
    {
        const Stored stored = storedOf(triangle);
        const uvec3 v = verticesOf(stored);
        if (stored.instance == nullptr) return {positions[v.x], positions[v.y], positions[v.z]};
        const Instance& i = *stored.instance;
        return {i.position(positions[v.x]), i.position(positions[v.y]), i.position(positions[v.z])};
    }
    [[nodiscard]] std::array<vec3, 3> normalsOf(uint32_t triangle) const
    {
        const Stored stored = storedOf(triangle);
        const uvec3 v = verticesOf(stored);
        if (stored.instance == nullptr) return {normals[v.x], normals[v.y], normals[v.z]};
        const Instance& i = *stored.instance;
        return {i.normal(normals[v.x]), i.normal(normals[v.y]), i.normal(normals[v.z])};
    }
    /// Lightmap coordinates of the corners, in texels of the page.
    [[nodiscard]] std::array<vec2, 3> texelsOf(uint32_t triangle) const
    {
        const Stored stored = storedOf(triangle);
        const uvec3 v = verticesOf(stored);
        if (stored.instance == nullptr) return {lightmapTexel[v.x], lightmapTexel[v.y], lightmapTexel[v.z]};
        const Instance& i = *stored.instance;
        return {i.texel(lightmapTexel[v.x]), i.texel(lightmapTexel[v.y]), i.texel(lightmapTexel[v.z])};
    }
    [[nodiscard]] bool isSolid(uint32_t triangle) const { return solid[storedOf(triangle).index] != 0; }
    [[nodiscard]] TexelSide texelSideOf(uint32_t triangle) const
    {
        return texelSides.empty() ? TexelSide::Front : texelSides[storedOf(triangle).index];
    }
    /// Whether both sides of a triangle are seen and share its texels.
    [[nodiscard]] bool sharesTexels(uint32_t triangle) const { return texelSideOf(triangle) != TexelSide::Front; }
    /// Whether texels on a triangle hold the mean light of both of its sides.
    [[nodiscard]] bool hasMeanTexels(uint32_t triangle) const { return texelSideOf(triangle) == TexelSide::Mean; }

    /// Unit, or zero for a degenerate triangle.
    [[nodiscard]] vec3 geometricNormal(uint32_t triangle) const
    {
        const Stored stored = storedOf(triangle);
        const vec3 normal = frames[stored.index].normal;
        return stored.instance == nullptr ? normal : stored.instance->normal(normal);
    }
    /// Width of a lightmap texel on a triangle, in metres; 0 where its lightmap triangle has no area.
    [[nodiscard]] float texelMeters(uint32_t triangle) const
    {
        const Stored stored = storedOf(triangle);
        return stored.instance == nullptr ? frames[stored.index].texelMeters
                                          : texelMeters(cornersOf(triangle), texelsOf(triangle));
    }
    [[nodiscard]] static float texelMeters(const std::array<vec3, 3>& corners, const std::array<vec2, 3>& texels);
    [[nodiscard]] vec3 centroid(uint32_t triangle) const
    {
        const std::array<vec3, 3> c = cornersOf(triangle);
        return (c[0] + c[1] + c[2]) / 3.0f;
    }
    [[nodiscard]] Bounds boundsOf(uint32_t triangle) const
    {
        Bounds bounds;
        for (const vec3 corner : cornersOf(triangle)) bounds.extend(corner);
        return bounds;
    }
    /// Gives an object whose stored triangles are shared its own, in world space. Triangles keep their numbers.
    /// `part`: any of the object's.
    void storeInWorldSpace(uint32_t part);
    /// For pages with `factor` times as many texels along each side.
    void scaleTexels(float factor);
    /// Bytes of all lists.
    [[nodiscard]] std::size_t byteCount() const;

private:
    static constexpr uint32_t kBlock = 64; ///< triangles
};

} // namespace halflight
