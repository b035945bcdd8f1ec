#include "bake/geometry/flatten.h"
#include "bake/geometry/shared_meshes.h"
#include "bake/geometry/solids.h"
#include "bake/geometry/triangle_frame.h"

#include "halflight/base/parallel.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <unordered_map>

namespace halflight {

float BakeGeometry::texelMeters(const std::array<vec3, 3>& corners, const std::array<vec2, 3>& texels)
{
    const float meters2 = glm::length(glm::cross(corners[1] - corners[0], corners[2] - corners[0]));
    const float texels2 = std::abs(cross2(texels[1] - texels[0], texels[2] - texels[0]));
    constexpr float kLeast = 1.0e-12f; // keeps the width of slivers finite
    return texels2 > 0.0f ? std::sqrt(meters2 / std::max(texels2, kLeast)) : 0.0f;
}

void BakeGeometry::findFrames()
{
    frames.resize(triangles.size());
    parallelFor(triangles.size(), 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const uvec3 t = triangles[i];
            const vec3 n = glm::cross(positions[t.y] - positions[t.x], positions[t.z] - positions[t.x]);
            const float meters2 = glm::length(n);
            frames[i] = {meters2 > 0.0f ? n / meters2 : vec3(0.0f),
                         texelMeters({positions[t.x], positions[t.y], positions[t.z]},
                                     {lightmapTexel[t.x], lightmapTexel[t.y], lightmapTexel[t.z]})};
        }
    });
    partOfBlock.clear();
    for (uint32_t p = 0; p < parts.size(); ++p) {
        const uint32_t end = parts[p].firstTriangle + parts[p].triangleCount;
        while (partOfBlock.size() * kBlock < end) partOfBlock.push_back(p);
    }
    if (!parts.empty()) partOfBlock.push_back(uint32_t(parts.size()) - 1);
}

void BakeGeometry::scaleTexels(float factor)
{
    for (vec2& texel : lightmapTexel) texel *= factor;
    for (Instance& instance : instances) instance.texelOffset *= factor; // the offset of scaled coordinates
    findFrames();
}

std::size_t BakeGeometry::byteCount() const
{
    const auto bytes = [](const auto& list) { return list.capacity() * sizeof(list[0]); };
    std::size_t sum = 0;
    for (const auto& set : uv) sum += bytes(set);
    return sum + bytes(parts) + bytes(instances) + bytes(triangles) + bytes(solid) + bytes(flipped) +
           bytes(texelSides) + bytes(positions) + bytes(normals) + bytes(colors) + bytes(lightmapTexel) +
           bytes(frames) + bytes(partOfBlock);
}

void BakeGeometry::storeInWorldSpace(uint32_t part)
{
    if (parts[part].instance == kOwn) return;
    const Instance& instance = instances[parts[part].instance];
    const int object = parts[part].object;
    while (part > 0 && parts[part - 1].object == object) --part;
    for (; part < parts.size() && parts[part].object == object; ++part) {
        Part& p = parts[part];
        const auto firstStored = uint32_t(triangles.size());
        const auto firstVertex = uint32_t(positions.size());
        for (uint32_t v = p.firstVertex; v < p.firstVertex + p.vertexCount; ++v) {
            positions.push_back(instance.position(positions[v]));
            normals.push_back(instance.normal(normals[v]));
            for (auto& set : uv) {
                if (!set.empty()) set.push_back(set[v]);
            }
            if (!colors.empty()) colors.push_back(colors[v]);
            lightmapTexel.push_back(p.page >= 0 ? instance.texel(lightmapTexel[v]) : vec2(0.0f));
        }
        for (uint32_t t = 0; t < p.triangleCount; ++t) {
            const uvec3 v = verticesOf({p.firstStored + t, &instance}) - p.firstVertex + firstVertex;
            triangles.push_back(v);
            solid.push_back(solid[p.firstStored + t]);
            flipped.push_back(0);
            if (!texelSides.empty()) texelSides.push_back(texelSides[p.firstStored + t]);
            const std::array<vec3, 3> corners{positions[v.x], positions[v.y], positions[v.z]};
            frames.push_back({instance.normal(frames[p.firstStored + t].normal),
                              texelMeters(corners, {lightmapTexel[v.x], lightmapTexel[v.y], lightmapTexel[v.z]})});
        }
        p.firstStored = firstStored;
        p.firstVertex = firstVertex;
        p.instance = kOwn;
    }
}

namespace {

using Instances = std::vector<std::optional<BakeGeometry::Instance>>;

/// Parts with their ranges, so that all can be filled in parallel. Returns the numbers of the parts whose triangles are
/// to be stored: all but those that share what an earlier object stores.
std::vector<uint32_t> listParts(const Scene& scene, GeometryFilter filter, const Instances& instances, BakeGeometry& g)
{
    std::vector<uint32_t> stored;
    std::vector<uint32_t> firstPartOfMesh(scene.meshes.size(), ~0u);
    uint32_t triangleCount = 0;
    uint32_t storedCount = 0;
    uint32_t vertexCount = 0;
    for (std::size_t o = 0; o < scene.objects.size(); ++o) {
        const Object& object = scene.objects[o];
        if (filter == GeometryFilter::Static && !object.isStatic) continue;
        const Mesh& mesh = scene.meshes[std::size_t(object.mesh)];
        uint32_t& earlier = firstPartOfMesh[std::size_t(object.mesh)];
        const bool stores = !instances[o] || earlier == ~0u;
        if (instances[o] && earlier == ~0u) earlier = uint32_t(g.parts.size());
        for (std::size_t p = 0; p < mesh.parts.size(); ++p) {
            const MeshPart& part = mesh.parts[p];
            BakeGeometry::Part out;
            out.object = int(o);
            out.mesh = object.mesh;
            out.part = int(p);
            out.material = part.material;
            out.side = part.side;
            out.firstTriangle = triangleCount;
            out.triangleCount = uint32_t(part.triangleCount());
            out.vertexCount = uint32_t(part.positions.size());
            out.castShadows = object.castShadows && materialOf(scene, part).castShadows;
            out.receiveShadows = object.receiveShadows && materialOf(scene, part).receiveShadows;
            out.page = part.lightmapUv.empty() ? -1 : object.lightmap.page;
            if (instances[o]) out.instance = uint32_t(g.instances.size());
            if (stores) {
                out.firstStored = storedCount;
                out.firstVertex = vertexCount;
                storedCount += out.triangleCount;
                vertexCount += out.vertexCount;
                stored.push_back(uint32_t(g.parts.size()));
            } else {
                out.firstStored = g.parts[earlier + p].firstStored;
                out.firstVertex = g.parts[earlier + p].firstVertex;
            }
            triangleCount += out.triangleCount;
            g.parts.push_back(out);
        }
        if (instances[o]) g.instances.push_back(*instances[o]);
    }
    g.triangles.resize(storedCount);
    g.positions.reserve(vertexCount + 1); // Embree reads 16 bytes at each position
    g.positions.resize(vertexCount);
    return stored;
}

/// Stores the triangles of a part: in world space, or as its mesh has them.
void storePart(const Scene& scene, const BakeGeometry::Part& out, int pageSize, BakeGeometry& g)
{
    const Object& object = scene.objects[std::size_t(out.object)];
    const Mesh& mesh = scene.meshes[std::size_t(out.mesh)];
    const MeshPart& part = mesh.parts[std::size_t(out.part)];
    const bool shared = out.instance != BakeGeometry::kOwn;
    const vec3 middle = shared ? middleOf(mesh) : vec3(0.0f);
    const bool mirrored = !shared && glm::determinant(mat3(object.worldFromObject)) < 0.0f;
    const mat3 fromNormal = shared ? mat3(1.0f) : worldFromNormal(mat3(object.worldFromObject));
    for (uint32_t v = 0; v < out.vertexCount; ++v) {
        const uint32_t w = out.firstVertex + v;
        g.positions[w] =
            shared ? part.positions[v] - middle : vec3(object.worldFromObject * vec4(part.positions[v], 1.0f));
        const vec3 n = fromNormal * (part.normals.empty() ? vec3(0, 1, 0) : part.normals[v]);
        const float length = glm::length(n);
        g.normals[w] = length > 0.0f ? n / length : vec3(0.0f, 1.0f, 0.0f);
        for (std::size_t set = 0; set < part.uv.size(); ++set) {
            if (!part.uv[set].empty()) g.uv[set][w] = part.uv[set][v];
        }
        if (!part.colors.empty()) g.colors[w] = part.colors[v];
        if (shared && !part.lightmapUv.empty()) {
            g.lightmapTexel[w] = part.lightmapUv[v];
        } else if (!shared && out.page >= 0) {
            g.lightmapTexel[w] =
                (object.lightmap.scale * part.lightmapUv[v] + object.lightmap.offset) * float(pageSize);
        }
    }
    for (uint32_t t = 0; t < out.triangleCount; ++t) {
        uvec3 triangle(part.indices[3 * t], part.indices[3 * t + 1], part.indices[3 * t + 2]);
        if (mirrored) std::swap(triangle.y, triangle.z);
        g.triangles[out.firstStored + t] = triangle + uvec3(out.firstVertex);
    }
}

/// Flips triangles whose texels hold the light of the back, and notes those whose sides share texels.
void takeTexelSides(const Scene& scene, BakeGeometry& g)
{
    std::vector<uint32_t> backs;
    for (uint32_t p = 0; p < g.parts.size(); ++p) {
        const BakeGeometry::Part part = g.parts[p];
        const std::vector<TexelSide>& sides =
            scene.meshes[std::size_t(part.mesh)].parts[std::size_t(part.part)].texelSides;
        for (uint32_t t = 0; t < sides.size(); ++t) {
            if (sides[t] == TexelSide::Back) backs.push_back(part.firstTriangle + t);
            if (sides[t] == TexelSide::Front || sides[t] == TexelSide::Back) continue;
            g.texelSides.resize(g.triangles.size(), TexelSide::Front);
            g.texelSides[part.firstStored + t] = sides[t];
        }
    }
    flipTriangles(g, backs);
}

} // namespace

std::vector<uint32_t> partsOnce(const BakeGeometry& geometry)
{
    std::vector<uint32_t> once;
    std::unordered_map<int, int> objectOfMesh; // the first instance of each shared mesh
    for (uint32_t i = 0; i < geometry.parts.size(); ++i) {
        const BakeGeometry::Part& part = geometry.parts[i];
        const bool own = part.instance == BakeGeometry::kOwn;
        if (own || objectOfMesh.try_emplace(part.mesh, part.object).first->second == part.object) once.push_back(i);
    }
    return once;
}

BakeGeometry flattenGeometry(const Scene& scene, int pageSize, GeometryFilter filter)
{
    BakeGeometry g;
    const std::vector<uint32_t> stored = listParts(scene, filter, shareMeshes(scene, pageSize, filter), g);
    const std::size_t vertexCount = g.positions.size();
    g.normals.resize(vertexCount);
    g.lightmapTexel.resize(vertexCount, vec2(0.0f));
    for (const BakeGeometry::Part& out : g.parts) {
        const MeshPart& part = scene.meshes[std::size_t(out.mesh)].parts[std::size_t(out.part)];
        for (std::size_t set = 0; set < part.uv.size(); ++set) {
            if (!part.uv[set].empty()) g.uv[set].resize(vertexCount, vec2(0.0f));
        }
        if (!part.colors.empty()) g.colors.resize(vertexCount, vec4(1.0f));
    }
    parallelFor(stored.size(), 4, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) storePart(scene, g.parts[stored[i]], pageSize, g);
    });
    g.findFrames();
    findSolids(scene, g);
    takeTexelSides(scene, g);
    return g;
}

SurfacePoint surfacePoint(const BakeGeometry& geometry, uint32_t triangle, vec2 barycentric)
{
    SurfacePoint point;
    TriangleFrame(geometry, triangle).put(barycentric, point);
    return point;
}

} // namespace halflight
