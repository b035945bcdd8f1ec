#include "unwrap/cuts/sheets.h"

#include "halflight/base/text.h"

#include <algorithm>

namespace halflight::charts {
namespace {

template<typename T> std::vector<T> chosen(const std::vector<T>& values, std::span<const uint32_t> indices)
{
    std::vector<T> out;
    if (values.empty()) return out;
    out.reserve(indices.size());
    for (const uint32_t i : indices) out.push_back(values[i]);
    return out;
}

/// Some triangles of a part, with the vertices that they use.
MeshPart partOfTriangles(const MeshPart& part, std::span<const uint32_t> triangles)
{
    constexpr uint32_t kUnused = ~0u;
    std::vector<uint32_t> newVertex(part.positions.size(), kUnused);
    std::vector<uint32_t> vertices;
    MeshPart out;
    out.indices.reserve(3 * triangles.size());
    for (const uint32_t t : triangles) {
        for (uint32_t k = 0; k < 3; ++k) {
            uint32_t& v = newVertex[part.indices[3 * t + k]];
            if (v == kUnused) {
                v = uint32_t(vertices.size());
                vertices.push_back(part.indices[3 * t + k]);
            }
            out.indices.push_back(v);
        }
    }
    out.positions = chosen(part.positions, vertices);
    out.normals = chosen(part.normals, vertices);
    out.tangents = chosen(part.tangents, vertices);
    for (std::size_t set = 0; set < part.uv.size(); ++set) out.uv[set] = chosen(part.uv[set], vertices);
    out.colors = chosen(part.colors, vertices);
    out.sourceVertex = part.sourceVertex.empty() ? vertices : chosen(part.sourceVertex, vertices);
    out.cutVertices = part.cutVertices;
    out.material = part.material;
    out.sourcePrimitive = part.sourcePrimitive;
    out.lightmapTexCoord = part.lightmapTexCoord;
    return out;
}

/// The other side of a front half: glTF reverses normals, and with them the tangent frame, of backs.
MeshPart backOf(const MeshPart& front)
{
    MeshPart back = front;
    back.side = SurfaceSide::Back;
    for (std::size_t i = 0; i + 2 < back.indices.size(); i += 3) std::swap(back.indices[i + 1], back.indices[i + 2]);
    for (vec3& normal : back.normals) normal = -normal;
    for (vec4& tangent : back.tangents) tangent = -tangent;
    return back;
}

TexelSide texelSideOf(SheetTexels texels)
{
    switch (texels) {
    case SheetTexels::FrontOfBoth:
        return TexelSide::FrontOfBoth;
    case SheetTexels::Mean:
        return TexelSide::Mean;
    case SheetTexels::Back:
        return TexelSide::Back;
    default:
        return TexelSide::Front;
    }
}

/// What becomes of a mesh.
struct Doubled {
    std::vector<MeshPart> parts;
    std::vector<uint32_t> portions; ///< by triangle
    std::vector<float> texelWidths;
};

/// Adds the parts that a part becomes. `texels`, `portions`: of its triangles; without portions all are 0.
void addParts(const MeshPart& part, std::span<const SheetTexels> texels, std::span<const uint32_t> portions,
              Doubled& out)
{
    std::vector<uint32_t> single;
    std::vector<uint32_t> both;
    for (uint32_t t = 0; t < texels.size(); ++t) (isDoubled(texels[t]) ? both : single).push_back(t);
    const auto addTriangles = [&](std::span<const uint32_t> triangles, uint32_t side, SheetTexels even) {
        for (const uint32_t t : triangles) {
            out.portions.push_back(2 * (portions.empty() ? 0 : portions[t]) + side);
            out.texelWidths.push_back(texels[t] == even ? kEvenTexels : 1.0f);
        }
    };
    if (!single.empty()) {
        MeshPart& rest = out.parts.emplace_back(both.empty() ? part : partOfTriangles(part, single));
        if (std::any_of(single.begin(), single.end(), [&](uint32_t t) { return texels[t] != SheetTexels::Front; })) {
            for (const uint32_t t : single) rest.texelSides.push_back(texelSideOf(texels[t]));
        }
        addTriangles(single, 0, SheetTexels::BothWithEvenFront);
    }
    if (both.empty()) return;
    MeshPart front = partOfTriangles(part, both);
    front.side = SurfaceSide::Front;
    MeshPart back = backOf(front);
    out.parts.push_back(std::move(front));
    out.parts.push_back(std::move(back));
    addTriangles(both, 0, SheetTexels::BothWithEvenFront);
    addTriangles(both, 1, SheetTexels::BothWithEvenBack);
}

} // namespace

void joinSheets(Scene& scene)
{
    for (Mesh& mesh : scene.meshes) {
        const bool hasHalves = std::any_of(mesh.parts.begin(), mesh.parts.end(),
                                           [](const MeshPart& part) { return part.side != SurfaceSide::Both; });
        // An earlier bake's layout has other charts than the joined mesh.
        for (MeshPart& part : mesh.parts)
            if (hasHalves && part.lightmapTexCoord == 1) part.uv[1].clear();
        std::erase_if(mesh.parts, [](const MeshPart& part) { return part.side == SurfaceSide::Back; });
        for (MeshPart& part : mesh.parts) {
            part.side = SurfaceSide::Both;
            part.texelSides.clear();
        }
    }
}

bool doubleSheets(Scene& scene, const std::vector<std::vector<SheetTexels>>& texels, std::span<const uint8_t> kept,
                  SceneCuts& cuts, std::vector<std::string>& warnings)
{
    bool changed = false;
    std::vector<std::string> withoutRoom;
    for (std::size_t m = 0; m < texels.size(); ++m) {
        std::vector<SheetTexels> ofMesh = texels[m];
        Mesh& mesh = scene.meshes[m];
        if (kept[m] != 0) {
            if (std::any_of(ofMesh.begin(), ofMesh.end(), isDoubled))
                withoutRoom.push_back(mesh.name.empty() ? "mesh " + std::to_string(m) : mesh.name);
            for (SheetTexels& t : ofMesh)
                if (isDoubled(t)) t = SheetTexels::FrontOfBoth;
        }
        if (std::all_of(ofMesh.begin(), ofMesh.end(), [](SheetTexels t) { return t == SheetTexels::Front; })) continue;
        const std::span<const uint32_t> portions = cuts.of(int(m));
        Doubled doubled;
        std::size_t first = 0;
        for (const MeshPart& part : mesh.parts) {
            const std::size_t count = part.triangleCount();
            addParts(part, std::span(ofMesh).subspan(first, count),
                     portions.empty() ? portions : portions.subspan(first, count), doubled);
            if (count == 0) doubled.parts.push_back(part);
            first += count;
        }
        mesh.parts = std::move(doubled.parts);
        cuts.portions.resize(scene.meshes.size());
        cuts.texelWidths.resize(scene.meshes.size());
        cuts.portions[m] = std::move(doubled.portions);
        cuts.texelWidths[m] = std::move(doubled.texelWidths);
        changed = true;
    }
    if (!withoutRoom.empty()) {
        warnings.push_back("the two sides of " + listOf(withoutRoom) +
                           " are lit differently, but share texels: the kept TEXCOORD_1 has no room for a second "
                           "side; --uv unwrap gives each side its own");
    }
    return changed;
}

} // namespace halflight::charts
