#include "scene/write/meshes/write_meshes.h"

#include "scene/document/texture_coordinates.h"
#include "scene/read/geometry/read_mesh.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace halflight {

namespace {

NewView indexView(const std::vector<uint32_t>& indices, std::size_t vertexCount, int& componentType)
{
    NewView view;
    view.target = gltf::kIndices;
    const bool isShort = vertexCount <= 65535; // 65535 itself means "restart"
    componentType = isShort ? gltf::kUnsignedShort : gltf::kUnsignedInt;
    const std::size_t bytes = isShort ? 2 : 4;
    view.bytes.resize(indices.size() * bytes);
    for (std::size_t i = 0; i < indices.size(); ++i) std::memcpy(&view.bytes[i * bytes], &indices[i], bytes);
    return view;
}

// min and max of an accessor as its file wants them: the stored numbers, not normalized.
void setBounds(Json& accessor, const AccessorView& view)
{
    AccessorView raw = view;
    raw.normalized = false;
    Json low = Json::array();
    Json high = Json::array();
    for (int c = 0; c < view.components; ++c) {
        float a = raw.number(0, c);
        float b = a;
        for (std::size_t i = 1; i < view.count; ++i) {
            a = std::min(a, raw.number(i, c));
            b = std::max(b, raw.number(i, c));
        }
        if (!std::isfinite(a) || !std::isfinite(b)) return;
        low.push_back(a);
        high.push_back(b);
    }
    accessor["min"] = std::move(low);
    accessor["max"] = std::move(high);
}

/// Whether all vertices are copies of vertices of the source, or lie between such.
bool hasValidSources(const MeshPart& part, std::size_t sourceCount)
{
    const auto isValid = [&](uint32_t v, std::size_t cuts) {
        return (v & kCutVertex) != 0 ? (v & ~kCutVertex) < cuts : v < sourceCount;
    };
    for (std::size_t i = 0; i < part.cutVertices.size(); ++i) {
        if (!isValid(part.cutVertices[i].from, i) || !isValid(part.cutVertices[i].to, i)) return false;
    }
    return std::all_of(part.sourceVertex.begin(), part.sourceVertex.end(),
                       [&](uint32_t v) { return isValid(v, part.cutVertices.size()); });
}

} // namespace

MeshWriter::MeshWriter(DocumentPatcher& patcher, const SourceDocument& source, const BakedScene& baked,
                       const std::vector<FileLayout>& layouts, const std::vector<int>& materials)
    : patcher_(patcher), source_(source), scene_(baked.scene), layouts_(layouts), materials_(materials),
      sides_(patcher), variants_(patcher, source, baked, materials)
{}

// The accessor with one element per vertex of the part, copied byte by byte: no format changes on the way. `between`
// is for vertices that a cut added. Normals and tangents of back halves are negated.
Result<int> MeshWriter::remap(const MeshPart& part, int accessor, const std::string& attribute, Between between)
{
    const bool negated = part.side == SurfaceSide::Back && (attribute == "NORMAL" || attribute == "TANGENT");
    const auto key = std::tuple(&part, accessor, between, negated);
    if (const auto it = remapped_.find(key); it != remapped_.end()) return it->second;
    const auto view = viewAccessor(source_, accessor);
    if (!view) return view.error();
    Json json = source_.json["accessors"][std::size_t(accessor)];
    for (const char* gone : {"bufferView", "byteOffset", "sparse", "min", "max"}) json.erase(gone);
    AccessorView copy = *view;
    copy.count = part.sourceVertex.size();
    copy.strideBytes =
        (view->bytesPerElement + 3) / 4 * 4; // glTF 2.0, section 3.6.2.4: vertex attributes align to 4 bytes
    copy.owned.assign(copy.count * copy.strideBytes, std::byte(0));
    const std::vector<std::byte> cut = cutElements(*view, part.cutVertices, between);
    for (std::size_t i = 0; i < copy.count; ++i) {
        const uint32_t v = part.sourceVertex[i];
        const std::byte* const element =
            (v & kCutVertex) != 0 ? &cut[(v & ~kCutVertex) * view->bytesPerElement] : view->at(v);
        std::memcpy(&copy.owned[i * copy.strideBytes], element, view->bytesPerElement);
        if (negated) negateElement(&copy.owned[i * copy.strideBytes], view->componentType, view->components);
    }
    copy.data = copy.owned.data();
    json["count"] = copy.count;
    if (source_.json["accessors"][std::size_t(accessor)].contains("min")) setBounds(json, copy);
    const int stride = copy.strideBytes != view->bytesPerElement ? int(copy.strideBytes) : 0;
    const int index = patcher_.addAccessor(std::move(json), {std::move(copy.owned), stride, gltf::kVertices});
    remapped_[key] = index;
    return index;
}

Result<Json> MeshWriter::primitiveJson(const MeshPart& part, const FileLayout& layout, const Json& source,
                                       const std::string& path)
{
    Json json = source;
    const std::size_t sourceCount = elementCount(source_, attributeOf(source, "POSITION"));
    const std::size_t count = part.positions.size();
    const bool split = !part.sourceVertex.empty();
    const bool isBroken = part.lightmapUv.size() != count || (split && part.sourceVertex.size() != count) ||
                          (!split && count != sourceCount) || !hasValidSources(part, sourceCount);
    if (isBroken) {
        return Error{ErrorCode::InvalidArgument, "the scene's vertices do not match those of the file it was read from",
                     path};
    }
    if (split) {
        for (const auto& [name, accessor] : json["attributes"].items()) {
            const auto index = remap(part, accessor.get<int>(), name, betweenOf(name));
            if (!index) return index.error();
            accessor = *index;
        }
        if (json.contains("targets")) {
            for (Json& target : json["targets"]) {
                for (const auto& [name, accessor] : target.items()) {
                    const auto index = remap(part, accessor.get<int>(), name, Between::Linear);
                    if (!index) return index.error();
                    accessor = *index;
                }
            }
        }
        // The compressed copy of an optional compression extension knows nothing of the new vertices.
        if (json.contains("extensions")) {
            json["extensions"].erase("KHR_draco_mesh_compression");
            if (json["extensions"].empty()) json.erase("extensions");
        }
    }
    const int mode = integerOf(source, "mode", gltf::kTriangles);
    std::vector<uint32_t> sourceIndices;
    if (const int accessor = integerOf(source, "indices"); accessor >= 0) {
        auto indices = readIntegers(source_, accessor);
        if (!indices) return indices.error();
        sourceIndices = std::move(*indices);
    }
    if (split || mode != gltf::kTriangles || trianglesOf(mode, sourceIndices, sourceCount) != part.indices) {
        int componentType = 0;
        NewView view = indexView(part.indices, count, componentType);
        json["indices"] = patcher_.addAccessor(
            {{"componentType", componentType}, {"count", part.indices.size()}, {"type", "SCALAR"}}, std::move(view));
        json.erase("mode");
    }
    NewView uvs;
    uvs.target = gltf::kVertices;
    std::vector<vec2> coordinates(count);
    std::transform(part.lightmapUv.begin(), part.lightmapUv.end(), coordinates.begin(),
                   [&](vec2 uv) { return layout.coordinate(uv); });
    uvs.bytes = bytesOf(coordinates);
    const int lightmapUv =
        patcher_.addAccessor({{"componentType", gltf::kFloat}, {"count", count}, {"type", "VEC2"}}, std::move(uvs));
    json["attributes"]["TEXCOORD_" + std::to_string(part.lightmapTexCoord)] = lightmapUv;
    // glTF wants the sets numbered without gaps: the lightmap's stands in for missing ones. Textures of a part that
    // lacks the set they read are seen at (0, 0), so for those it is zeros.
    int zeroUv = -1;
    for (int k = 0; k < part.lightmapTexCoord; ++k) {
        Json& attributes = json["attributes"];
        const std::string name = "TEXCOORD_" + std::to_string(k);
        if (attributes.contains(name)) continue;
        const bool isRead = readsTexCoord(element(source_.json, "materials", sourceMaterialOf(scene_, part)), k);
        if (isRead && zeroUv < 0) {
            zeroUv = patcher_.addAccessor({{"componentType", gltf::kFloat}, {"count", count}, {"type", "VEC2"}},
                                          {std::vector<std::byte>(count * sizeof(vec2)), 0, gltf::kVertices});
        }
        attributes[name] = isRead ? zeroUv : lightmapUv;
    }
    return json;
}

bool MeshWriter::isCopied(const MeshPart& part) const
{
    if (part.material < 0) return false;
    const auto material = std::size_t(part.material);
    return materials_[material] != scene_.materials[material].sourceMaterial;
}

// A primitive of the source becomes as many as it has parts. Back halves of an earlier bake that have no part are gone.
Result<Json> MeshWriter::patchedMesh(int sceneMesh)
{
    const Mesh& mesh = scene_.meshes[std::size_t(sceneMesh)];
    const Json& source = source_.json["meshes"][std::size_t(mesh.sourceMesh)];
    const Json& sourcePrimitives = source["primitives"];
    const std::string path = pathOf("meshes", std::size_t(mesh.sourceMesh)) + "/primitives/";
    for (const MeshPart& part : mesh.parts) {
        if (part.sourcePrimitive < 0 || std::size_t(part.sourcePrimitive) >= sourcePrimitives.size()) {
            return Error{ErrorCode::InvalidArgument, "a part of the mesh has no primitive in the source file",
                         path + std::to_string(part.sourcePrimitive)};
        }
    }
    Json patched = source;
    Json primitives = Json::array();
    for (std::size_t s = 0; s < sourcePrimitives.size(); ++s) {
        const Json& primitive = sourcePrimitives[s];
        bool hasPart = false;
        for (const MeshPart& part : mesh.parts) {
            if (part.sourcePrimitive != int(s)) continue;
            hasPart = true;
            primitives.push_back(primitive);
            if (isCopied(part)) primitives.back()["material"] = materials_[std::size_t(part.material)];
            variants_.setIn(primitives.back(), part.material);
            if (part.lightmapUv.empty()) continue;
            auto json =
                primitiveJson(part, layouts_[std::size_t(sceneMesh)], primitives.back(), path + std::to_string(s));
            if (!json) return json.error();
            sides_.setIn(*json, part.side);
            primitives.back() = std::move(*json);
        }
        const bool isOldBack =
            markedSide(element(source_.json, "materials", integerOf(primitive, "material"))) == SurfaceSide::Back;
        if (!hasPart && !isOldBack) primitives.push_back(primitive);
    }
    patched["primitives"] = std::move(primitives);
    return patched;
}

Status MeshWriter::setNodeMesh(int node, int sceneMesh)
{
    const auto [it, isNew] = indexOf_.try_emplace(sceneMesh, meshes_.size());
    if (isNew) {
        auto patched = patchedMesh(sceneMesh);
        if (!patched) return patched.error();
        meshes_.emplace_back(scene_.meshes[std::size_t(sceneMesh)].sourceMesh, std::move(*patched));
    }
    nodes_.emplace_back(node, it->second);
    return {};
}

void MeshWriter::finish()
{
    if (nodes_.empty()) return;
    // A source mesh that no node uses any more gives its place to the first mesh made from it.
    Json& nodes = patcher_.json["nodes"];
    std::set<int> rewritten;
    for (const auto& [node, mesh] : nodes_) rewritten.insert(node);
    std::set<int> stillUsed;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        if (rewritten.count(int(i)) == 0 && nodes[i].contains("mesh")) stillUsed.insert(nodes[i]["mesh"].get<int>());
    }
    std::vector<int> place(meshes_.size());
    std::set<int> taken;
    for (std::size_t i = 0; i < meshes_.size(); ++i) {
        const int source = meshes_[i].first;
        if (stillUsed.count(source) == 0 && taken.insert(source).second) {
            place[i] = source;
            patcher_.json["meshes"][std::size_t(source)] = std::move(meshes_[i].second);
        } else {
            place[i] = patcher_.append("meshes", std::move(meshes_[i].second));
        }
    }
    for (const auto& [node, mesh] : nodes_) nodes[std::size_t(node)]["mesh"] = place[mesh];
}

} // namespace halflight
