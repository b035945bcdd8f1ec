#include "scene/load/validate.h"

#include "scene/document/decode/compression.h"
#include "scene/document/fallback_buffers.h"
#include "scene/document/references.h"
#include "scene/document/types.h"
#include "scene/load/extensions.h"

#include <algorithm>
#include <array>
#include <string_view>

namespace halflight {
namespace {

// An element without data behind it costs no file bytes, so a small file could ask for any amount of memory.
constexpr uint64_t kMaxImplicitElements = 1u << 20;
constexpr uint64_t kMaxInt = 0x7fffffff;
constexpr uint64_t kMaxByteLength = 0xffffffff;

// A non-negative integer member up to `limit`. `required`: it must be there.
Status checkUnsigned(const Json& object, const char* key, bool required, uint64_t limit, const std::string& path,
                     uint64_t& value)
{
    const Json& number = member(object, key);
    if (number.is_null()) return required ? Status(invalid(path, std::string("has no ") + key)) : Status();
    if (!number.is_number_unsigned()) return invalid(path, std::string(key) + " is not an unsigned integer");
    value = number.get<uint64_t>();
    if (value > limit) return invalid(path, std::string(key) + " is too large (" + std::to_string(value) + ")");
    return {};
}

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

Status checkBuffers(const Json& json, bool isBinary)
{
    const Json& buffers = member(json, "buffers");
    for (std::size_t i = 0; i < buffers.size(); ++i) {
        const std::string path = pathOf("buffers", i);
        uint64_t length = 0;
        if (Status s = checkUnsigned(buffers[i], "byteLength", true, kMaxByteLength, path, length); !s) return s;
        if (length == 0) return invalid(path, "byteLength is 0");
        const Json& uri = member(buffers[i], "uri");
        if (uri.is_null() && !(isBinary && i == 0) && !isFallbackBuffer(buffers[i]))
            return invalid(path, "has neither a uri nor a binary chunk");
    }
    const Json& views = member(json, "bufferViews");
    for (std::size_t i = 0; i < views.size(); ++i) {
        const std::string path = pathOf("bufferViews", i);
        uint64_t buffer = 0;
        uint64_t offset = 0;
        uint64_t length = 0;
        uint64_t stride = 0;
        if (Status s = checkUnsigned(views[i], "buffer", true, kMaxInt, path, buffer); !s) return s;
        if (Status s = checkUnsigned(views[i], "byteOffset", false, kMaxByteLength, path, offset); !s) return s;
        if (Status s = checkUnsigned(views[i], "byteLength", true, kMaxByteLength, path, length); !s) return s;
        if (Status s = checkUnsigned(views[i], "byteStride", false, 252, path, stride); !s) return s;
        if (buffer >= buffers.size()) {
            return invalid(path,
                           "refers to buffer " + std::to_string(buffer) + " of " + std::to_string(buffers.size()));
        }
        if (length == 0) return invalid(path, "byteLength is 0");
        if (offset + length > buffers[buffer]["byteLength"].get<uint64_t>()) {
            return invalid(path, "reaches past the end of buffer " + std::to_string(buffer));
        }
    }
    const Json& images = member(json, "images");
    for (std::size_t i = 0; i < images.size(); ++i) {
        const std::string path = pathOf("images", i);
        uint64_t view = 0;
        if (Status s = checkUnsigned(images[i], "bufferView", false, kMaxInt, path, view); !s) return s;
        const bool hasView = images[i].contains("bufferView");
        if (hasView && view >= views.size()) {
            return invalid(path,
                           "refers to buffer view " + std::to_string(view) + " of " + std::to_string(views.size()));
        }
        if (hasView == images[i].contains("uri")) return invalid(path, "needs either a uri or a bufferView");
    }
    return {};
}

// The numbers that tinygltf narrows to int.
Status checkAccessorNumbers(const Json& json)
{
    constexpr std::string_view kTypes[] = {"SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"};
    const Json& accessors = member(json, "accessors");
    for (std::size_t i = 0; i < accessors.size(); ++i) {
        const std::string path = pathOf("accessors", i);
        const auto type = accessors[i]["type"].get<std::string>();
        if (std::find(std::begin(kTypes), std::end(kTypes), type) == std::end(kTypes))
            return invalid(path, "has an unknown type");
        uint64_t value = 0;
        for (const char* key : {"bufferView", "byteOffset"}) {
            if (Status s = checkUnsigned(accessors[i], key, false, kMaxInt, path, value); !s) return s;
        }
        for (const char* key : {"count", "componentType"}) {
            if (Status s = checkUnsigned(accessors[i], key, true, kMaxInt, path, value); !s) return s;
        }
        const Json& sparse = member(accessors[i], "sparse");
        if (sparse.is_null()) continue;
        const std::string sparsePath = path + "/sparse";
        if (Status s = checkUnsigned(sparse, "count", true, kMaxInt, sparsePath, value); !s) return s;
        for (const char* part : {"indices", "values"}) {
            const Json& object = member(sparse, part);
            if (Status s = checkUnsigned(object, "bufferView", true, kMaxInt, sparsePath, value); !s) return s;
            if (Status s = checkUnsigned(object, "byteOffset", false, kMaxInt, sparsePath, value); !s) return s;
        }
        if (Status s = checkUnsigned(member(sparse, "indices"), "componentType", true, kMaxInt, sparsePath, value); !s)
            return s;
    }
    return {};
}

// A camera has the lens that its type says.
Status checkCameras(const Json& json)
{
    const Json& cameras = member(json, "cameras");
    for (std::size_t i = 0; i < cameras.size(); ++i) {
        const auto type = cameras[i]["type"].get<std::string>();
        if (type != "perspective" && type != "orthographic")
            return invalid(pathOf("cameras", i), "type is neither perspective nor orthographic");
        if (!cameras[i].contains(type)) return invalid(pathOf("cameras", i), "has no " + type);
    }
    return {};
}

Status checkIndex(int index, std::size_t count, const char* what, const std::string& path)
{
    if (index < 0 || std::size_t(index) >= count) {
        return invalid(path,
                       std::string("refers to ") + what + " " + std::to_string(index) + " of " + std::to_string(count));
    }
    return {};
}

Status checkAccessors(const tinygltf::Model& model)
{
    for (std::size_t i = 0; i < model.buffers.size(); ++i) {
        if (model.buffers[i].data.empty()) return invalid(pathOf("buffers", i), "holds no data");
    }
    for (std::size_t i = 0; i < model.bufferViews.size(); ++i) {
        const auto& view = model.bufferViews[i];
        if (view.byteOffset + view.byteLength > model.buffers[std::size_t(view.buffer)].data.size()) {
            return invalid(pathOf("bufferViews", i), "reaches past the end of buffer " + std::to_string(view.buffer));
        }
    }
    const auto fits = [&](int bufferView, uint64_t offset, uint64_t stride, uint64_t count, uint64_t bytes) {
        return offset + (count - 1) * stride + bytes <= model.bufferViews[std::size_t(bufferView)].byteLength;
    };
    for (std::size_t i = 0; i < model.accessors.size(); ++i) {
        const auto& accessor = model.accessors[i];
        const std::string path = pathOf("accessors", i);
        const uint64_t bytes = elementBytes(accessor.componentType, accessor.type);
        if (bytes == 0) return invalid(path, "has an unknown type or component type");
        if (accessor.count == 0) return invalid(path, "has no elements");
        if (accessor.bufferView >= 0) {
            if (Status s = checkIndex(accessor.bufferView, model.bufferViews.size(), "buffer view", path); !s) return s;
            const auto& view = model.bufferViews[std::size_t(accessor.bufferView)];
            const uint64_t stride = view.byteStride != 0 ? view.byteStride : bytes;
            if (stride < bytes) return invalid(path, "elements are longer than the stride of their buffer view");
            if (!fits(accessor.bufferView, accessor.byteOffset, stride, accessor.count, bytes)) {
                return invalid(path, "reads past the end of its buffer view");
            }
        } else if (accessor.count > kMaxImplicitElements) {
            return invalid(path, "has " + std::to_string(accessor.count) + " elements but no data");
        }
        if (!accessor.sparse.isSparse) continue;
        const auto& sparse = accessor.sparse;
        const uint64_t indexBytes = uint64_t(componentBytes(sparse.indices.componentType));
        const bool isUnsigned = sparse.indices.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
                                sparse.indices.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
                                sparse.indices.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
        if (!isUnsigned) return invalid(path, "sparse indices are not unsigned integers");
        if (sparse.count < 1 || uint64_t(sparse.count) > accessor.count)
            return invalid(path, "sparse count is out of range");
        if (Status s = checkIndex(sparse.indices.bufferView, model.bufferViews.size(), "buffer view", path); !s)
            return s;
        if (Status s = checkIndex(sparse.values.bufferView, model.bufferViews.size(), "buffer view", path); !s)
            return s;
        if (!fits(sparse.indices.bufferView, uint64_t(sparse.indices.byteOffset), indexBytes, uint64_t(sparse.count),
                  indexBytes) ||
            !fits(sparse.values.bufferView, uint64_t(sparse.values.byteOffset), bytes, uint64_t(sparse.count), bytes)) {
            return invalid(path, "sparse data reads past the end of its buffer view");
        }
    }
    return {};
}

Status checkMeshes(const tinygltf::Model& model)
{
    for (std::size_t m = 0; m < model.meshes.size(); ++m) {
        for (std::size_t p = 0; p < model.meshes[m].primitives.size(); ++p) {
            const auto& primitive = model.meshes[m].primitives[p];
            const std::string path = pathOf("meshes", m) + "/primitives/" + std::to_string(p);
            if (primitive.mode < -1 || primitive.mode > 6) return invalid(path, "mode is not one of 0 to 6");
            if (primitive.material != -1) {
                if (Status s = checkIndex(primitive.material, model.materials.size(), "material", path); !s) return s;
            }
            if (primitive.indices != -1) {
                if (Status s = checkIndex(primitive.indices, model.accessors.size(), "accessor", path); !s) return s;
            }
            // All vertex attributes, morph targets included, have one element per vertex.
            const tinygltf::Accessor* first = nullptr;
            const auto checkAttributes = [&](const std::map<std::string, int>& attributes) -> Status {
                for (const auto& [name, accessor] : attributes) {
                    if (Status s = checkIndex(accessor, model.accessors.size(), "accessor", path); !s) return s;
                    const auto& values = model.accessors[std::size_t(accessor)];
                    if (first == nullptr) first = &values;
                    if (values.count != first->count) {
                        return invalid(path, "attributes differ in length: " + name + " has " +
                                                 std::to_string(values.count) + " elements, another " +
                                                 std::to_string(first->count));
                    }
                }
                return {};
            };
            if (Status s = checkAttributes(primitive.attributes); !s) return s;
            for (const auto& target : primitive.targets) {
                if (Status s = checkAttributes(target); !s) return s;
            }
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
    uint64_t limit = kFree;
    for (const auto& buffer : document.model.buffers) limit += 8 * uint64_t(buffer.data.size());
    uint64_t sum = 0;
    auto& json = const_cast<Json&>(document.json); // the visitor below only reads
    visitAccessors(json, [&](Json& index) {
        if (index.is_number_unsigned() && index.get<uint64_t>() < document.model.accessors.size())
            sum += document.model.accessors[index.get<std::size_t>()].count;
    });
    if (sum <= limit) return {};
    return invalid("/accessors", "meshes, nodes and animations read " + std::to_string(sum) +
                                     " elements in all, more than the limit of " + std::to_string(limit) +
                                     " for a file with so little data");
}

Status checkNodes(const tinygltf::Model& model)
{
    const std::size_t count = model.nodes.size();
    std::vector<int> parent(count, -1);
    for (std::size_t i = 0; i < count; ++i) {
        const auto& node = model.nodes[i];
        const std::string path = pathOf("nodes", i);
        if (node.mesh != -1) {
            if (Status s = checkIndex(node.mesh, model.meshes.size(), "mesh", path); !s) return s;
        }
        if (node.camera != -1) {
            if (Status s = checkIndex(node.camera, model.cameras.size(), "camera", path); !s) return s;
        }
        if (node.skin != -1) {
            if (Status s = checkIndex(node.skin, model.skins.size(), "skin", path); !s) return s;
        }
        for (const int child : node.children) {
            if (Status s = checkIndex(child, count, "node", path); !s) return s;
            if (parent[std::size_t(child)] != -1) {
                return invalid(pathOf("nodes", std::size_t(child)), "is a child of more than one node");
            }
            parent[std::size_t(child)] = int(i);
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
    for (std::size_t s = 0; s < model.scenes.size(); ++s) {
        for (const int node : model.scenes[s].nodes) {
            if (Status status = checkIndex(node, count, "node", pathOf("scenes", s)); !status) return status;
            if (parent[std::size_t(node)] != -1) {
                return invalid(pathOf("scenes", s),
                               "lists node " + std::to_string(node) + ", which is not a root node");
            }
        }
    }
    return {};
}

Status checkTextures(const SourceDocument& document)
{
    const auto& model = document.model;
    for (std::size_t i = 0; i < model.textures.size(); ++i) {
        const auto& texture = model.textures[i];
        const std::string path = pathOf("textures", i);
        if (texture.source != -1) {
            if (Status s = checkIndex(texture.source, model.images.size(), "image", path); !s) return s;
        }
        if (texture.sampler != -1) {
            if (Status s = checkIndex(texture.sampler, model.samplers.size(), "sampler", path); !s) return s;
        }
    }
    return {};
}

} // namespace

Status checkBeforeParsing(const Json& json, bool isBinary)
{
    if (!json.is_object()) return Error{ErrorCode::FileInvalid, "the JSON is not an object"};
    if (Status s = checkVersion(json); !s) return s;
    if (Status s = checkTypes(json); !s) return s;
    if (Status s = checkExtensions(json); !s) return s;
    if (Status s = checkBuffers(json, isBinary); !s) return s;
    if (Status s = checkCameras(json); !s) return s;
    return checkAccessorNumbers(json);
}

Status checkAfterParsing(const SourceDocument& document)
{
    // The typed view and the JSON must agree, since extensions are read from the JSON by the same indices.
    const auto& model = document.model;
    const auto same = [&](const char* array, std::size_t count) {
        return member(document.json, array).size() == count;
    };
    if (!same("nodes", model.nodes.size()) || !same("meshes", model.meshes.size()) ||
        !same("accessors", model.accessors.size()) || !same("materials", model.materials.size()) ||
        !same("textures", model.textures.size()) || !same("images", model.images.size())) {
        return Error{ErrorCode::FileInvalid, "an object of the file lacks required properties"};
    }
    if (Status s = checkAccessors(model); !s) return s;
    if (Status s = checkMeshes(model); !s) return s;
    if (Status s = checkElementSum(document); !s) return s;
    if (Status s = checkTextures(document); !s) return s;
    if (model.defaultScene != -1) {
        if (Status s = checkIndex(model.defaultScene, model.scenes.size(), "scene", "/scene"); !s) return s;
    }
    return checkNodes(model);
}

} // namespace halflight
