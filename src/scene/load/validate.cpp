#include "scene/load/validate.h"

#include "scene/document/decode/compression.h"
#include "scene/document/fallback_buffers.h"
#include "scene/document/references.h"
#include "scene/document/types.h"
#include "scene/load/extensions.h"

#include <optional>
#include <string_view>

namespace halflight {
namespace {

// An element without data behind it costs no file bytes, so a small file could ask for any amount of memory.
constexpr uint64_t kMaxImplicitElements = 1u << 20;

Status checkVersion(const Json& json)
{
    const Json& asset = member(json, "asset");
    const Json& version = member(asset, "version");
    if (!version.is_string()) return invalid("/asset", "the file names no glTF version");
    const auto major = [](const std::string& text) { return text.substr(0, text.find('.')); };
    const auto text = version.get<std::string>();
    if (major(text) != "2")
        return Error{ErrorCode::Unsupported, "glTF version " + text + " is not 2.x", "/asset/version"};
    const Json& minimum = member(asset, "minVersion");
    if (minimum.is_string() && minimum.get<std::string>() != "2.0") {
        return Error{ErrorCode::Unsupported, "needs glTF version " + minimum.get<std::string>(), "/asset/minVersion"};
    }
    return {};
}

Status checkExtensions(const Json& json)
{
    const Json& required = member(json, "extensionsRequired");
    if (required.is_null()) return {};
    for (const Json& name : required) {
        const auto text = name.get<std::string>();
        if (!isSupportedExtension(text) && !isHarmlessExtension(text)) {
            return Error{ErrorCode::Unsupported,
                         "the file requires the extension " + text + ", which is not supported" + conversionHint(text),
                         "/extensionsRequired"};
        }
    }
    return {};
}

/// A member that refers to an element of a top-level array, where it is there.
Status checkReference(const Json& json, const char* array, const Json& index, const char* what, const std::string& path)
{
    if (index.is_null() || isIndexInto(json, array, index)) return {};
    return invalid(path, std::string("refers to ") + what + " " + index.dump() + " of " +
                             std::to_string(member(json, array).size()));
}

Status checkBuffers(const Json& json, bool isBinary)
{
    const Json& buffers = member(json, "buffers");
    for (std::size_t i = 0; i < buffers.size(); ++i) {
        const std::string path = pathOf("buffers", i);
        if (bytesIn(buffers[i], "byteLength") == 0) return invalid(path, "byteLength is 0");
        if (!buffers[i].contains("uri") && !(isBinary && i == 0) && !isFallbackBuffer(buffers[i]))
            return invalid(path, "has neither a uri nor a binary chunk");
    }
    const Json& views = member(json, "bufferViews");
    for (std::size_t i = 0; i < views.size(); ++i) {
        const std::string path = pathOf("bufferViews", i);
        if (Status s = checkReference(json, "buffers", views[i]["buffer"], "buffer", path); !s) return s;
        const auto buffer = views[i]["buffer"].get<std::size_t>();
        const std::size_t length = bytesIn(views[i], "byteLength");
        if (length == 0) return invalid(path, "byteLength is 0");
        if (uint64_t(bytesIn(views[i], "byteOffset")) + length > bytesIn(buffers[buffer], "byteLength"))
            return invalid(path, "reaches past the end of buffer " + std::to_string(buffer));
        if (const std::size_t stride = bytesIn(views[i], "byteStride"); stride > 252 || stride % 4 != 0)
            return invalid(path, "byteStride is " + std::to_string(stride) + ", not a multiple of 4 up to 252");
    }
    const Json& images = member(json, "images");
    for (std::size_t i = 0; i < images.size(); ++i) {
        const std::string path = pathOf("images", i);
        const Json& view = member(images[i], "bufferView");
        if (Status s = checkReference(json, "bufferViews", view, "buffer view", path); !s) return s;
        if (view.is_null() != images[i].contains("uri")) return invalid(path, "needs either a uri or a bufferView");
    }
    return {};
}

// A camera has the lens that its type says, and a spot light its cone.
Status checkLenses(const Json& json)
{
    const Json& cameras = member(json, "cameras");
    for (std::size_t i = 0; i < cameras.size(); ++i) {
        const std::string type = stringOf(cameras[i], "type");
        if (type != "perspective" && type != "orthographic")
            return invalid(pathOf("cameras", i), "type is neither perspective nor orthographic");
        if (!cameras[i].contains(type)) return invalid(pathOf("cameras", i), "has no " + type);
    }
    const Json& lights = member(extensionOf(json, "KHR_lights_punctual"), "lights");
    for (std::size_t i = 0; i < lights.size(); ++i) {
        if (stringOf(lights[i], "type") == "spot" && !lights[i].contains("spot"))
            return invalid("/extensions/KHR_lights_punctual" + pathOf("lights", i), "is a spot light and has no spot");
    }
    return {};
}

/// Whether elements that begin at `offset` lie in the view. No sum is beyond 64 bits: all are below 2^32.
bool fits(const Json& view, uint64_t offset, uint64_t stride, uint64_t count, uint64_t bytes)
{
    return offset + (count - 1) * stride + bytes <= bytesIn(view, "byteLength");
}

Status checkSparse(const Json& json, const Json& sparse, uint64_t elements, uint64_t bytes, const std::string& path)
{
    const Json& indices = sparse["indices"];
    const Json& values = sparse["values"];
    const int type = integerOf(indices, "componentType");
    if (type != gltf::kUnsignedByte && type != gltf::kUnsignedShort && type != gltf::kUnsignedInt)
        return invalid(path, "sparse indices are not unsigned integers");
    const std::size_t count = bytesIn(sparse, "count");
    if (count < 1 || count > elements) return invalid(path, "sparse count is out of range");
    const auto indexBytes = uint64_t(componentBytes(type));
    for (const auto& [part, size] : {std::pair(&indices, indexBytes), std::pair(&values, bytes)}) {
        const Json& view = member(*part, "bufferView");
        if (Status s = checkReference(json, "bufferViews", view, "buffer view", path); !s) return s;
        if (!fits(json["bufferViews"][view.get<std::size_t>()], bytesIn(*part, "byteOffset"), size, count, size))
            return invalid(path, "sparse data reads past the end of its buffer view");
    }
    return {};
}

Status checkAccessors(const SourceDocument& document)
{
    const Json& views = member(document.json, "bufferViews");
    for (std::size_t i = 0; i < document.buffers.size(); ++i) {
        if (document.buffers[i].empty()) return invalid(pathOf("buffers", i), "holds no data");
    }
    for (std::size_t i = 0; i < views.size(); ++i) {
        const auto buffer = views[i]["buffer"].get<std::size_t>();
        if (buffer >= document.buffers.size() ||
            uint64_t(bytesIn(views[i], "byteOffset")) + bytesIn(views[i], "byteLength") >
                document.buffers[buffer].size())
            return invalid(pathOf("bufferViews", i), "reaches past the end of buffer " + std::to_string(buffer));
    }
    const Json& accessors = member(document.json, "accessors");
    for (std::size_t i = 0; i < accessors.size(); ++i) {
        const Json& accessor = accessors[i];
        const std::string path = pathOf("accessors", i);
        const std::size_t bytes = elementSize(accessor).bytes;
        const std::size_t count = bytesIn(accessor, "count");
        if (bytes == 0) return invalid(path, "has an unknown type or component type");
        if (count == 0) return invalid(path, "has no elements");
        if (const Json& index = member(accessor, "bufferView"); !index.is_null()) {
            if (Status s = checkReference(document.json, "bufferViews", index, "buffer view", path); !s) return s;
            const Json& view = views[index.get<std::size_t>()];
            const std::size_t stride = strideIn(view, bytes);
            if (stride < bytes) return invalid(path, "elements are longer than the stride of their buffer view");
            if (!fits(view, bytesIn(accessor, "byteOffset"), stride, count, bytes))
                return invalid(path, "reads past the end of its buffer view");
        } else if (count > kMaxImplicitElements) {
            return invalid(path, "has " + std::to_string(count) + " elements but no data");
        }
        if (const Json& sparse = member(accessor, "sparse"); !sparse.is_null()) {
            if (Status s = checkSparse(document.json, sparse, count, bytes, path); !s) return s;
        }
    }
    return {};
}

Status checkPrimitive(const SourceDocument& document, const Json& primitive, const std::string& path)
{
    const Json& json = document.json;
    if (integerOf(primitive, "mode", gltf::kTriangles) > 6) return invalid(path, "mode is not one of 0 to 6");
    const Json& indices = member(primitive, "indices");
    if (Status s = checkReference(json, "materials", member(primitive, "material"), "material", path); !s) return s;
    if (Status s = checkReference(json, "accessors", indices, "accessor", path); !s) return s;
    if (!indices.is_null() && !json["accessors"][indices.get<std::size_t>()].contains("bufferView"))
        return invalid(path, "indices are an accessor without a buffer view");
    // All vertex attributes, morph targets included, have one element per vertex.
    std::optional<std::size_t> first;
    const auto checkAttributes = [&](const Json& attributes) -> Status {
        for (const auto& [name, accessor] : attributes.items()) {
            if (Status s = checkReference(json, "accessors", accessor, "accessor", path); !s) return s;
            const std::size_t count = elementCount(document, accessor.get<int>());
            if (!first) first = count;
            if (count != *first) {
                return invalid(path, "attributes differ in length: " + name + " has " + std::to_string(count) +
                                         " elements, another " + std::to_string(*first));
            }
        }
        return {};
    };
    if (Status s = checkAttributes(primitive["attributes"]); !s) return s;
    for (const Json& target : member(primitive, "targets")) {
        if (Status s = checkAttributes(target); !s) return s;
    }
    return {};
}

Status checkMeshes(const SourceDocument& document)
{
    const Json& meshes = member(document.json, "meshes");
    for (std::size_t m = 0; m < meshes.size(); ++m) {
        const Json& primitives = meshes[m]["primitives"];
        for (std::size_t p = 0; p < primitives.size(); ++p) {
            const std::string path = pathOf("meshes", m) + "/primitives/" + std::to_string(p);
            if (Status s = checkPrimitive(document, primitives[p], path); !s) return s;
        }
    }
    return {};
}

// Each reference to an accessor costs memory, the accessor's bytes are in the file once at most. 2^23 elements over all
// references are free (some 0.5 GiB as vertices); beyond that, 8 for each byte of the buffers: data without an accessor
// of its own is shared, in files of a sensible kind, by a few meshes.
Status checkElementSum(const SourceDocument& document)
{
    constexpr uint64_t kFree = uint64_t(1) << 23;
    const uint64_t limit = kFree + 8 * bufferBytes(document);
    uint64_t sum = 0;
    auto& json = const_cast<Json&>(document.json); // the visitor below only reads
    visitAccessors(json, [&](Json& index) {
        if (isIndexInto(json, "accessors", index)) sum += elementCount(document, index.get<int>());
    });
    if (sum <= limit) return {};
    return invalid("/accessors", "meshes, nodes and animations read " + std::to_string(sum) +
                                     " elements in all, more than the limit of " + std::to_string(limit) +
                                     " for a file with so little data");
}

Status checkNodes(const Json& json)
{
    const Json& nodes = member(json, "nodes");
    const std::size_t count = nodes.size();
    std::vector<int> parent(count, -1);
    for (std::size_t i = 0; i < count; ++i) {
        const std::string path = pathOf("nodes", i);
        for (const auto& [key, array] :
             {std::pair("mesh", "meshes"), std::pair("camera", "cameras"), std::pair("skin", "skins")}) {
            if (Status s = checkReference(json, array, member(nodes[i], key), key, path); !s) return s;
        }
        for (const Json& child : member(nodes[i], "children")) {
            if (Status s = checkReference(json, "nodes", child, "node", path); !s) return s;
            int& parentOfChild = parent[child.get<std::size_t>()];
            if (parentOfChild != -1)
                return invalid(pathOf("nodes", child.get<std::size_t>()), "is a child of more than one node");
            parentOfChild = int(i);
        }
    }
    // With one parent each, a cycle is a walk upwards that meets itself. state: 0 unknown, 1 on this walk, 2 safe.
    std::vector<uint8_t> state(count, 0);
    std::vector<std::size_t> walk;
    for (std::size_t i = 0; i < count; ++i) {
        walk.clear();
        int at = int(i);
        while (at >= 0 && state[std::size_t(at)] == 0) {
            state[std::size_t(at)] = 1;
            walk.push_back(std::size_t(at));
            at = parent[std::size_t(at)];
        }
        if (at >= 0 && state[std::size_t(at)] == 1)
            return invalid(pathOf("nodes", std::size_t(at)), "is its own ancestor");
        for (const std::size_t visited : walk) state[visited] = 2;
    }
    const Json& scenes = member(json, "scenes");
    for (std::size_t s = 0; s < scenes.size(); ++s) {
        for (const Json& node : member(scenes[s], "nodes")) {
            if (Status status = checkReference(json, "nodes", node, "node", pathOf("scenes", s)); !status)
                return status;
            if (parent[node.get<std::size_t>()] != -1)
                return invalid(pathOf("scenes", s), "lists node " + node.dump() + ", which is not a root node");
        }
    }
    return checkReference(json, "scenes", member(json, "scene"), "scene", "/scene");
}

Status checkTextures(const Json& json)
{
    const Json& textures = member(json, "textures");
    for (std::size_t i = 0; i < textures.size(); ++i) {
        const std::string path = pathOf("textures", i);
        const Json& webp = member(extensionOf(textures[i], "EXT_texture_webp"), "source");
        if (!webp.is_null() && readsCompression("EXT_texture_webp")) { // in place of the texture's own
            if (!isIndexInto(json, "images", webp))
                return invalid(path + "/extensions/EXT_texture_webp", "source is not an image's index");
        } else if (Status s = checkReference(json, "images", member(textures[i], "source"), "image", path); !s) {
            return s;
        }
        if (Status s = checkReference(json, "samplers", member(textures[i], "sampler"), "sampler", path); !s) return s;
    }
    return {};
}

} // namespace

Status checkPacked(const Json& json, bool isBinary)
{
    if (!json.is_object()) return Error{ErrorCode::FileInvalid, "the JSON is not an object"};
    if (Status s = checkVersion(json); !s) return s;
    if (Status s = checkTypes(json); !s) return s;
    if (Status s = checkExtensions(json); !s) return s;
    if (Status s = checkBuffers(json, isBinary); !s) return s;
    return checkLenses(json);
}

Status checkUnpacked(const SourceDocument& document)
{
    if (Status s = checkAccessors(document); !s) return s;
    if (Status s = checkMeshes(document); !s) return s;
    if (Status s = checkElementSum(document); !s) return s;
    if (Status s = checkTextures(document.json); !s) return s;
    return checkNodes(document.json);
}

} // namespace halflight
