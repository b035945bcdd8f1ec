#include "unwrap/surface/split.h"

#include <numeric>

namespace halflight::charts {
namespace {

template<typename T> void copyVertices(std::vector<T>& values, const std::vector<uint32_t>& sources)
{
    if (values.empty()) return;
    values.reserve(values.size() + sources.size());
    for (const uint32_t source : sources) values.push_back(T(values[source]));
}

} // namespace

void assignLightmapUv(MeshPart& part, std::span<const vec2> cornerUv)
{
    assert(cornerUv.size() == part.indices.size());
    constexpr uint32_t kEnd = ~0u;
    const auto originals = uint32_t(part.positions.size());
    part.lightmapUv.assign(originals, vec2(0.0f));
    std::vector<char> assigned(originals, 0);
    std::vector<uint32_t> nextCopy(originals, kEnd); // list of a vertex's copies
    std::vector<uint32_t> sources;                   // of the copies, in order
    for (std::size_t c = 0; c < part.indices.size(); ++c) {
        uint32_t vertex = part.indices[c];
        const uint32_t original = vertex;
        if (!assigned[vertex]) {
            assigned[vertex] = 1;
            part.lightmapUv[vertex] = cornerUv[c];
            continue;
        }
        while (part.lightmapUv[vertex] != cornerUv[c]) {
            if (nextCopy[vertex] == kEnd) {
                const auto copy = uint32_t(nextCopy.size());
                nextCopy[vertex] = copy;
                nextCopy.push_back(kEnd);
                part.lightmapUv.push_back(cornerUv[c]);
                sources.push_back(original);
            }
            vertex = nextCopy[vertex];
        }
        part.indices[c] = vertex;
    }
    if (sources.empty()) return;
    if (part.sourceVertex.empty()) {
        part.sourceVertex.resize(originals);
        std::iota(part.sourceVertex.begin(), part.sourceVertex.end(), 0u);
    }
    copyVertices(part.positions, sources);
    copyVertices(part.normals, sources);
    copyVertices(part.tangents, sources);
    for (auto& uv : part.uv) copyVertices(uv, sources);
    copyVertices(part.colors, sources);
    copyVertices(part.sourceVertex, sources);
}

int freeTexCoord(const Scene& scene, const Mesh& mesh)
{
    const auto isFree = [&](int n) {
        for (const MeshPart& part : mesh.parts) {
            const Material& material = materialOf(scene, part);
            for (const TextureRef* ref : material.textureRefs()) {
                if (*ref && ref->texCoord == n) return false;
            }
        }
        return true;
    };
    // The reader has seen extensions as well, whose textures the scene does not hold.
    int n = 1;
    for (const MeshPart& part : mesh.parts) n = std::max(n, part.lightmapTexCoord);
    while (!isFree(n)) ++n;
    return n;
}

} // namespace halflight::charts
