#include "bake/stages.h"

#include "halflight/base/parallel.h"

#include <algorithm>
#include <cmath>

namespace halflight {

void BakeGeometry::findFrames()
{
    frames.resize(triangles.size());
    parallelFor(triangles.size(), 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const uvec3 t = triangles[i];
            const vec3 n = glm::cross(positions[t.y] - positions[t.x], positions[t.z] - positions[t.x]);
            const float meters2 = glm::length(n);
            const float texels =
                std::abs(cross2(lightmapTexel[t.y] - lightmapTexel[t.x], lightmapTexel[t.z] - lightmapTexel[t.x]));
            constexpr float kLeast = 1.0e-12f; // keeps the width of slivers finite
            frames[i] = {meters2 > 0.0f ? n / meters2 : vec3(0.0f),
                         texels > 0.0f ? std::sqrt(meters2 / std::max(texels, kLeast)) : 0.0f};
        }
    });
}

BakeGeometry flattenGeometry(const Scene& scene, int pageSize, GeometryFilter filter)
{
    // Ranges first, so that all parts can be filled in parallel.
    BakeGeometry g;
    uint32_t triangleCount = 0;
    uint32_t vertexCount = 0;
    bool anyColor = false;
    for (std::size_t o = 0; o < scene.objects.size(); ++o) {
        const Object& object = scene.objects[o];
        if (filter == GeometryFilter::Static && !object.isStatic) continue;
        const Mesh& mesh = scene.meshes[std::size_t(object.mesh)];
        for (std::size_t p = 0; p < mesh.parts.size(); ++p) {
            const MeshPart& part = mesh.parts[p];
            BakeGeometry::Part out;
            out.object = int(o);
            out.mesh = object.mesh;
            out.part = int(p);
            out.material = part.material;
            out.firstTriangle = triangleCount;
            out.triangleCount = uint32_t(part.indices.size() / 3);
            out.firstVertex = vertexCount;
            out.vertexCount = uint32_t(part.positions.size());
            out.castShadows = object.castShadows && materialOf(scene, part).castShadows;
            out.receiveShadows = object.receiveShadows && materialOf(scene, part).receiveShadows;
            out.page = part.lightmapUv.empty() ? -1 : object.lightmap.page;
            triangleCount += out.triangleCount;
            vertexCount += out.vertexCount;
            anyColor = anyColor || !part.colors.empty();
            g.parts.push_back(out);
        }
    }
    g.triangles.resize(triangleCount);
    g.partOfTriangle.resize(triangleCount);
    g.positions.resize(vertexCount);
    g.normals.resize(vertexCount);
    for (auto& uv : g.uv) uv.resize(vertexCount, vec2(0.0f));
    g.lightmapTexel.resize(vertexCount, vec2(0.0f));
    if (anyColor) g.colors.resize(vertexCount, vec4(1.0f));

    parallelFor(g.parts.size(), 4, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const BakeGeometry::Part& out = g.parts[i];
            const Object& object = scene.objects[std::size_t(out.object)];
            const MeshPart& part = scene.meshes[std::size_t(out.mesh)].parts[std::size_t(out.part)];
            const mat3 linear(object.worldFromObject);
            const bool mirrored = glm::determinant(linear) < 0.0f;
            // Normals transform by the inverse transpose. The cofactor matrix is equal up to scale, and also exists for
            // transforms that flatten the object.
            const mat3 cofactor(glm::cross(linear[1], linear[2]), glm::cross(linear[2], linear[0]),
                                glm::cross(linear[0], linear[1]));
            const mat3 worldFromNormal = mirrored ? -cofactor : cofactor;
            for (uint32_t v = 0; v < out.vertexCount; ++v) {
                const uint32_t w = out.firstVertex + v;
                g.positions[w] = vec3(object.worldFromObject * vec4(part.positions[v], 1.0f));
                const vec3 n = worldFromNormal * (part.normals.empty() ? vec3(0, 1, 0) : part.normals[v]);
                const float length = glm::length(n);
                g.normals[w] = length > 0.0f ? n / length : vec3(0.0f, 1.0f, 0.0f);
                for (int c = 0; c < 2; ++c) {
                    if (!part.uv[std::size_t(c)].empty()) g.uv[c][w] = part.uv[std::size_t(c)][v];
                }
                if (!part.colors.empty()) g.colors[w] = part.colors[v];
                if (out.page >= 0) {
                    g.lightmapTexel[w] =
                        (object.lightmap.scale * part.lightmapUv[v] + object.lightmap.offset) * float(pageSize);
                }
            }
            for (uint32_t t = 0; t < out.triangleCount; ++t) {
                uvec3 triangle(part.indices[3 * t], part.indices[3 * t + 1], part.indices[3 * t + 2]);
                if (mirrored) std::swap(triangle.y, triangle.z);
                g.triangles[out.firstTriangle + t] = triangle + uvec3(out.firstVertex);
                g.partOfTriangle[out.firstTriangle + t] = uint32_t(i);
            }
        }
    });
    g.findFrames();
    findSolids(scene, g);
    return g;
}

void Integrator::surfacesAlong(std::span<const Segment> segments, std::span<std::optional<vec2>> out) const
{
    parallelFor(segments.size(), 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) out[i] = surfacesBetween(segments[i].from, segments[i].to);
    });
}

SurfacePoint surfacePoint(const BakeGeometry& geometry, uint32_t triangle, vec2 barycentric)
{
    SurfacePoint point;
    TriangleFrame(geometry, triangle).put(barycentric, point);
    return point;
}

} // namespace halflight
