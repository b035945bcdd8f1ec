#include "scene/document/document.h"

#include "scene/document/uri.h"

#include <algorithm>
#include <cassert>
#include <cstring>

namespace halflight {
namespace {

const Json kNull;

float normalizedFloat(const std::byte* p, int componentType, bool normalized)
{
    const auto load = [p]<typename T>(T) {
        T v;
        std::memcpy(&v, p, sizeof v);
        return v;
    };
    // glTF 2.0 section 3.11, "Animations": f = c / 127, max(c / 127, -1), and so on.
    switch (componentType) {
    case gltf::kByte: {
        const float v = load(int8_t{});
        return normalized ? std::max(v / 127.0f, -1.0f) : v;
    }
    case gltf::kUnsignedByte:
        return load(uint8_t{}) / (normalized ? 255.0f : 1.0f);
    case gltf::kShort: {
        const float v = load(int16_t{});
        return normalized ? std::max(v / 32767.0f, -1.0f) : v;
    }
    case gltf::kUnsignedShort:
        return load(uint16_t{}) / (normalized ? 65535.0f : 1.0f);
    case gltf::kUnsignedInt:
        return float(load(uint32_t{}));
    default:
        return load(float{});
    }
}

} // namespace

const Json& member(const Json& object, const char* key)
{
    if (!object.is_object()) return kNull;
    const auto it = object.find(key);
    return it == object.end() ? kNull : *it;
}

const Json& extensionOf(const Json& object, const char* name)
{
    return member(member(object, "extensions"), name);
}

const Json& element(const Json& document, const char* array, int index)
{
    const Json& list = member(document, array);
    return list.is_array() && index >= 0 && std::size_t(index) < list.size() ? list[std::size_t(index)] : kNull;
}

bool isIndexInto(const Json& document, const char* array, const Json& index)
{
    return index.is_number_unsigned() && index.get<uint64_t>() < member(document, array).size();
}

int integerOf(const Json& object, const char* key, int absent)
{
    const Json& value = member(object, key);
    return value.is_number_integer() ? value.get<int>() : absent;
}

std::size_t bytesIn(const Json& object, const char* key)
{
    const Json& value = member(object, key);
    return value.is_number_integer() ? value.get<std::size_t>() : 0;
}

std::string stringOf(const Json& object, const char* key)
{
    const Json& value = member(object, key);
    return value.is_string() ? value.get<std::string>() : std::string();
}

const Json& primitiveOf(const SourceDocument& document, int mesh, int primitive)
{
    return element(document.json, "meshes", mesh)["primitives"][std::size_t(primitive)];
}

int attributeOf(const Json& primitive, const std::string& name)
{
    return integerOf(member(primitive, "attributes"), name.c_str());
}

std::size_t elementCount(const SourceDocument& document, int accessor)
{
    return bytesIn(element(document.json, "accessors", accessor), "count");
}

int activeSceneIndex(const SourceDocument& document)
{
    return integerOf(document.json, "scene", 0);
}

uint64_t bufferBytes(const SourceDocument& document)
{
    uint64_t bytes = 0;
    for (const auto& buffer : document.buffers) bytes += buffer.size();
    return bytes;
}

int componentBytes(int componentType)
{
    switch (componentType) {
    case gltf::kByte:
    case gltf::kUnsignedByte:
        return 1;
    case gltf::kShort:
    case gltf::kUnsignedShort:
        return 2;
    case gltf::kUnsignedInt:
    case gltf::kFloat:
        return 4;
    default:
        return 0;
    }
}

ElementSize elementSize(const Json& accessor)
{
    const auto bytes = std::size_t(componentBytes(integerOf(accessor, "componentType")));
    const Json& type = member(accessor, "type");
    if (type == "SCALAR") return {1, bytes};
    for (int n = 2; n <= 4; ++n) {
        const auto rows = std::size_t(n);
        if (type == "VEC" + std::to_string(n)) return {n, rows * bytes};
        if (type == "MAT" + std::to_string(n)) return {n * n, rows * ((rows * bytes + 3) / 4 * 4)};
    }
    return {};
}

std::size_t strideIn(const Json& view, std::size_t elementBytes)
{
    const std::size_t stride = bytesIn(view, "byteStride");
    return stride != 0 ? stride : elementBytes;
}

std::span<const std::byte> viewBytes(const SourceDocument& document, int view)
{
    const Json& json = element(document.json, "bufferViews", view);
    return std::span(document.buffers[std::size_t(integerOf(json, "buffer"))])
        .subspan(bytesIn(json, "byteOffset"), bytesIn(json, "byteLength"));
}

float AccessorView::number(std::size_t i, int c) const
{
    return normalizedFloat(at(i) + std::size_t(c) * std::size_t(componentBytes(componentType)), componentType,
                           normalized);
}

uint32_t AccessorView::integer(std::size_t i, int c) const
{
    const std::byte* p = at(i) + std::size_t(c) * std::size_t(componentBytes(componentType));
    uint32_t value = 0; // little-endian, like the file
    std::memcpy(&value, p, std::size_t(componentBytes(componentType)));
    return value;
}

Result<AccessorView> viewAccessor(const SourceDocument& document, int index)
{
    const Json& accessor = element(document.json, "accessors", index);
    assert(!accessor.is_null());
    const ElementSize size = elementSize(accessor);
    const Json& sparse = member(accessor, "sparse");
    AccessorView view;
    view.count = elementCount(document, index);
    view.componentType = integerOf(accessor, "componentType");
    view.components = size.components;
    view.bytesPerElement = size.bytes;
    view.normalized = member(accessor, "normalized") == true;
    view.strideBytes = size.bytes;
    if (const int source = integerOf(accessor, "bufferView"); source >= 0) {
        view.strideBytes = strideIn(element(document.json, "bufferViews", source), size.bytes);
        view.data = viewBytes(document, source).data() + bytesIn(accessor, "byteOffset");
        if (sparse.is_null()) return view;
    }
    // Without a buffer view all elements are zero; sparse values replace some.
    view.owned.resize(view.count * view.bytesPerElement);
    if (view.data != nullptr) {
        for (std::size_t i = 0; i < view.count; ++i)
            std::memcpy(view.owned.data() + i * view.bytesPerElement, view.at(i), view.bytesPerElement);
    }
    view.data = view.owned.data();
    view.strideBytes = view.bytesPerElement;
    if (sparse.is_null()) return view;
    const auto bytesOf = [&](const Json& part) {
        return viewBytes(document, integerOf(part, "bufferView")).data() + bytesIn(part, "byteOffset");
    };
    AccessorView indices;
    indices.data = bytesOf(sparse["indices"]);
    indices.componentType = integerOf(sparse["indices"], "componentType");
    indices.strideBytes = std::size_t(componentBytes(indices.componentType));
    const std::byte* values = bytesOf(sparse["values"]);
    for (std::size_t i = 0, count = bytesIn(sparse, "count"); i < count; ++i) {
        const uint32_t target = indices.integer(i);
        if (target >= view.count) {
            return invalid(pathOf("accessors", std::size_t(index)), "sparse index " + std::to_string(target) +
                                                                        " is beyond the accessor's " +
                                                                        std::to_string(view.count) + " elements");
        }
        std::memcpy(view.owned.data() + target * view.bytesPerElement, values + i * view.bytesPerElement,
                    view.bytesPerElement);
    }
    return view;
}

template<int N> Result<std::vector<glm::vec<N, float>>> readVectors(const SourceDocument& document, int accessor)
{
    const auto view = viewAccessor(document, accessor);
    if (!view) return view.error();
    if (view->components < N) {
        return invalid(pathOf("accessors", std::size_t(accessor)), "has " + std::to_string(view->components) +
                                                                       " components where " + std::to_string(N) +
                                                                       " are needed");
    }
    std::vector<glm::vec<N, float>> values(view->count);
    for (std::size_t i = 0; i < view->count; ++i) {
        for (int c = 0; c < N; ++c) values[i][c] = view->number(i, c);
    }
    return values;
}
template Result<std::vector<glm::vec<2, float>>> readVectors<2>(const SourceDocument&, int);
template Result<std::vector<glm::vec<3, float>>> readVectors<3>(const SourceDocument&, int);
template Result<std::vector<glm::vec<4, float>>> readVectors<4>(const SourceDocument&, int);

Result<std::vector<uint32_t>> readIntegers(const SourceDocument& document, int accessor)
{
    const auto view = viewAccessor(document, accessor);
    if (!view) return view.error();
    if (view->components != 1 || view->componentType == gltf::kFloat) {
        return invalid(pathOf("accessors", std::size_t(accessor)), "is not a list of integers");
    }
    std::vector<uint32_t> values(view->count);
    for (std::size_t i = 0; i < view->count; ++i) values[i] = view->integer(i);
    return values;
}

Result<std::vector<std::byte>> imageBytes(const SourceDocument& document, int index)
{
    const Json& image = element(document.json, "images", index);
    assert(!image.is_null());
    const std::string object = pathOf("images", std::size_t(index));
    if (const int view = integerOf(image, "bufferView"); view >= 0) {
        const std::span<const std::byte> bytes = viewBytes(document, view);
        return std::vector<std::byte>(bytes.begin(), bytes.end());
    }
    constexpr uint64_t kMaxImageBytes = uint64_t(1) << 31; // decoders count bytes in 31 bits
    auto bytes = readUri(image["uri"].get_ref<const std::string&>(), document.directory, kMaxImageBytes);
    if (!bytes) return Error{bytes.error().code, "image " + bytes.error().message, object};
    return bytes;
}

} // namespace halflight
