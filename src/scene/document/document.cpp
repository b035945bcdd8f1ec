#include "scene/document/document.h"

#include "scene/document/uri.h"

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
    case TINYGLTF_COMPONENT_TYPE_BYTE: {
        const float v = load(int8_t{});
        return normalized ? std::max(v / 127.0f, -1.0f) : v;
    }
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        return load(uint8_t{}) / (normalized ? 255.0f : 1.0f);
    case TINYGLTF_COMPONENT_TYPE_SHORT: {
        const float v = load(int16_t{});
        return normalized ? std::max(v / 32767.0f, -1.0f) : v;
    }
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        return load(uint16_t{}) / (normalized ? 65535.0f : 1.0f);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
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

int accessorComponents(int type)
{
    return std::max(0, tinygltf::GetNumComponentsInType(uint32_t(type)));
}

int componentBytes(int componentType)
{
    switch (componentType) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        return 1;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        return 2;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
        return 4;
    default:
        return 0;
    }
}

std::size_t elementBytes(int componentType, int type)
{
    const auto bytes = std::size_t(componentBytes(componentType));
    const auto column = [&](std::size_t rows) { return (rows * bytes + 3) / 4 * 4; };
    switch (type) {
    case TINYGLTF_TYPE_MAT2:
        return 2 * column(2);
    case TINYGLTF_TYPE_MAT3:
        return 3 * column(3);
    case TINYGLTF_TYPE_MAT4:
        return 4 * column(4);
    default:
        return bytes * std::size_t(accessorComponents(type));
    }
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
    const tinygltf::Model& model = document.model;
    assert(index >= 0 && std::size_t(index) < model.accessors.size());
    const tinygltf::Accessor& accessor = model.accessors[std::size_t(index)];
    AccessorView view;
    view.count = accessor.count;
    view.componentType = accessor.componentType;
    view.components = accessorComponents(accessor.type);
    view.bytesPerElement = elementBytes(accessor.componentType, accessor.type);
    view.normalized = accessor.normalized;
    view.strideBytes = view.bytesPerElement;
    if (accessor.bufferView >= 0) {
        const tinygltf::BufferView& source = model.bufferViews[std::size_t(accessor.bufferView)];
        if (source.byteStride != 0) view.strideBytes = source.byteStride;
        view.data = reinterpret_cast<const std::byte*>(model.buffers[std::size_t(source.buffer)].data.data()) +
                    source.byteOffset + accessor.byteOffset;
        if (!accessor.sparse.isSparse) return view;
    }
    // Without a buffer view all elements are zero; sparse values replace some.
    view.owned.resize(view.count * view.bytesPerElement);
    if (view.data != nullptr) {
        for (std::size_t i = 0; i < view.count; ++i) {
            std::memcpy(view.owned.data() + i * view.bytesPerElement, view.at(i), view.bytesPerElement);
        }
    }
    view.data = view.owned.data();
    view.strideBytes = view.bytesPerElement;
    if (accessor.sparse.isSparse) {
        const auto bytesOf = [&](int bufferView, int offset) {
            const tinygltf::BufferView& source = model.bufferViews[std::size_t(bufferView)];
            return reinterpret_cast<const std::byte*>(model.buffers[std::size_t(source.buffer)].data.data()) +
                   source.byteOffset + std::size_t(offset);
        };
        AccessorView indices;
        indices.data = bytesOf(accessor.sparse.indices.bufferView, accessor.sparse.indices.byteOffset);
        indices.componentType = accessor.sparse.indices.componentType;
        indices.strideBytes = std::size_t(componentBytes(indices.componentType));
        const std::byte* values = bytesOf(accessor.sparse.values.bufferView, accessor.sparse.values.byteOffset);
        for (std::size_t i = 0; i < std::size_t(accessor.sparse.count); ++i) {
            const uint32_t target = indices.integer(i);
            if (target >= view.count) {
                return invalid(pathOf("accessors", std::size_t(index)), "sparse index " + std::to_string(target) +
                                                                            " is beyond the accessor's " +
                                                                            std::to_string(view.count) + " elements");
            }
            std::memcpy(view.owned.data() + target * view.bytesPerElement, values + i * view.bytesPerElement,
                        view.bytesPerElement);
        }
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
    if (view->components != 1 || view->componentType == TINYGLTF_COMPONENT_TYPE_FLOAT) {
        return invalid(pathOf("accessors", std::size_t(accessor)), "is not a list of integers");
    }
    std::vector<uint32_t> values(view->count);
    for (std::size_t i = 0; i < view->count; ++i) values[i] = view->integer(i);
    return values;
}

Result<std::vector<std::byte>> imageBytes(const SourceDocument& document, int index)
{
    const tinygltf::Model& model = document.model;
    assert(index >= 0 && std::size_t(index) < model.images.size());
    const tinygltf::Image& image = model.images[std::size_t(index)];
    const std::string object = pathOf("images", std::size_t(index));
    if (image.bufferView >= 0) {
        const tinygltf::BufferView& view = model.bufferViews[std::size_t(image.bufferView)];
        const auto* first =
            reinterpret_cast<const std::byte*>(model.buffers[std::size_t(view.buffer)].data.data()) + view.byteOffset;
        return std::vector<std::byte>(first, first + view.byteLength);
    }
    constexpr uint64_t kMaxImageBytes = uint64_t(1) << 31; // decoders count bytes in 31 bits
    auto bytes = readUri(image.uri, document.directory, kMaxImageBytes);
    if (!bytes) return Error{bytes.error().code, "image " + bytes.error().message, object};
    return bytes;
}

} // namespace halflight
