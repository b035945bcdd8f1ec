#include "scene/document/decode/decompress.h"

#include "scene/document/decode/compression.h"
#include "scene/document/decode/decode_draco.h"
#include "scene/document/decode/decode_meshopt.h"
#include "scene/document/fallback_buffers.h"

#include <map>
#include <set>

namespace halflight {
namespace {

bool hasCompression(const Json& json)
{
    for (const char* list : {"extensionsUsed", "extensionsRequired"}) {
        for (const Json& name : member(json, list)) {
            if (isCompressedGeometry(name.get_ref<const std::string&>())) return true;
        }
    }
    for (const Json& view : member(json, "bufferViews")) {
        for (const char* name : kMeshoptExtensions) {
            if (!extensionOf(view, name).is_null()) return true;
        }
    }
    for (const Json& mesh : member(json, "meshes")) {
        for (const Json& primitive : member(mesh, "primitives")) {
            if (!extensionOf(primitive, kDracoExtension).is_null()) return true;
        }
    }
    return false;
}

Status decodeViews(Json& json, DecodedBuffer& decoded)
{
    for (std::size_t i = 0; i < member(json, "bufferViews").size(); ++i) {
        Json& view = json["bufferViews"][i];
        for (const char* name : kMeshoptExtensions) {
            if (extensionOf(view, name).is_null()) continue;
            const std::string path = pathOf("bufferViews", i) + "/extensions/" + name;
            if (Status s = decodeMeshoptView(decoded, view, name, path); !s) return s;
        }
    }
    return {};
}

Status decodePrimitives(Json& json, DecodedBuffer& decoded)
{
    DracoDecoder draco(decoded);
    for (std::size_t m = 0; m < member(json, "meshes").size(); ++m) {
        const Json& primitives = member(json["meshes"][m], "primitives");
        for (std::size_t p = 0; primitives.is_array() && p < primitives.size(); ++p) {
            if (extensionOf(primitives[p], kDracoExtension).is_null()) continue;
            const std::string path = pathOf("meshes", m) + "/primitives/" + std::to_string(p);
            if (Status s = draco.decode(json["meshes"][m]["primitives"][p], path); !s) return s;
        }
    }
    return {};
}

void eraseNames(Json& json, const char* list)
{
    Json& names = json[list];
    Json kept = Json::array();
    for (const Json& name : names) {
        const auto& text = name.get_ref<const std::string&>();
        const bool stays = text == kDracoExtension && !DracoMesh::isSupported();
        if (stays || !isCompressedGeometry(text)) kept.push_back(name);
    }
    names = std::move(kept);
    if (names.empty()) json.erase(list);
}

/// Compressed data and fallback buffers.
Status dropUnusedBuffers(Json& json, std::vector<std::vector<std::byte>>& buffers)
{
    std::set<uint64_t> used;
    Json& views = json["bufferViews"];
    for (std::size_t i = 0; i < views.size(); ++i) {
        const auto buffer = views[i]["buffer"].get<uint64_t>();
        if (isFallbackBuffer(json["buffers"][buffer]))
            return invalid(pathOf("bufferViews", i), "refers to a buffer without data, and is not compressed");
        used.insert(buffer);
    }
    std::map<uint64_t, std::size_t> place;
    Json kept = Json::array();
    std::vector<std::vector<std::byte>> keptBuffers;
    for (const uint64_t buffer : used) {
        place[buffer] = keptBuffers.size();
        kept.push_back(json["buffers"][buffer]);
        keptBuffers.push_back(std::move(buffers[std::size_t(buffer)]));
    }
    for (Json& view : views) view["buffer"] = place[view["buffer"].get<uint64_t>()];
    json["buffers"] = std::move(kept);
    buffers = std::move(keptBuffers);
    if (json["bufferViews"].empty()) json.erase("bufferViews");
    if (json["buffers"].empty()) json.erase("buffers");
    return {};
}

} // namespace

Status decompress(Json& json, std::vector<std::vector<std::byte>>& buffers)
{
    if (!hasCompression(json)) return {};
    DecodedBuffer decoded(json, buffers);
    if (Status s = decodeViews(json, decoded); !s) return s;
    if (Status s = decodePrimitives(json, decoded); !s) return s;
    decoded.finish();
    for (const char* list : {"extensionsUsed", "extensionsRequired"}) eraseNames(json, list);
    return dropUnusedBuffers(json, buffers);
}

} // namespace halflight
