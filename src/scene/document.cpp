#include "scene/document.h"

#include "halflight/base/file.h"
#include "scene/decompress.h"
#include "scene/fallback_buffers.h"
#include "scene/finite_accessors.h"
#include "scene/strip.h"
#include "scene/uri.h"
#include "scene/validate.h"

#include <cstring>

namespace halflight {
namespace {

const Json kNull;

constexpr uint32_t kGlbMagic = 0x46546C67;     // "glTF"
constexpr uint32_t kChunkJson = 0x4E4F534A;    // "JSON"
constexpr uint32_t kChunkBinary = 0x004E4942;  // "BIN"
constexpr uint64_t kMaxFileBytes = 0xffffffff; // what GLB can hold
constexpr int kMaxJsonDepth = 128;

uint32_t readU32(std::span<const std::byte> bytes, std::size_t offset)
{
    uint32_t value = 0;
    for (int i = 3; i >= 0; --i) value = value << 8 | uint32_t(bytes[offset + std::size_t(i)]);
    return value;
}

struct Chunks {
    std::string_view json;
    std::span<const std::byte> binary; ///< a GLB's second chunk, where that is binary data
    bool isBinary = false;             ///< a GLB
};

// The chunks of a GLB, or all of a .gltf as JSON. Every chunk header is checked against the file.
Result<Chunks> chunksOf(std::span<const std::byte> bytes)
{
    if (bytes.empty()) return Error{ErrorCode::FileInvalid, "the file is empty"};
    if (bytes.size() < 4 || readU32(bytes, 0) != kGlbMagic) {
        std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
        if (text.substr(0, 3) == "\xEF\xBB\xBF") text.remove_prefix(3);
        const std::size_t first = text.find_first_not_of(" \t\r\n");
        if (first == std::string_view::npos || text[first] != '{') {
            return Error{ErrorCode::FileInvalid, "the file is neither a GLB (wrong magic) nor glTF JSON"};
        }
        return Chunks{text, {}, false};
    }
    if (bytes.size() < 20) return Error{ErrorCode::FileInvalid, "the GLB ends within its header"};
    if (readU32(bytes, 4) != 2) {
        return Error{ErrorCode::Unsupported, "GLB version " + std::to_string(readU32(bytes, 4)) + " is not 2"};
    }
    const uint64_t length = readU32(bytes, 8);
    if (length > bytes.size()) {
        return Error{ErrorCode::FileInvalid, "the GLB is cut short: its header says " + std::to_string(length) +
                                                 " bytes, the file has " + std::to_string(bytes.size())};
    }
    if (length < 20) {
        return Error{ErrorCode::FileInvalid,
                     "the GLB's header gives its length as " + std::to_string(length) + " bytes, too few for a chunk"};
    }
    if (readU32(bytes, 16) != kChunkJson)
        return Error{ErrorCode::FileInvalid, "the first chunk of the GLB is not JSON"};
    uint64_t offset = 12;
    Chunks chunks;
    chunks.isBinary = true;
    for (int chunk = 0; offset < length; ++chunk) {
        if (length - offset < 8) return Error{ErrorCode::FileInvalid, "the GLB ends within a chunk header"};
        const uint64_t chunkLength = readU32(bytes, offset);
        if (chunkLength > length - offset - 8) {
            return Error{ErrorCode::FileInvalid,
                         "chunk " + std::to_string(chunk) + " of the GLB is longer than the file"};
        }
        const auto content = bytes.subspan(std::size_t(offset) + 8, std::size_t(chunkLength));
        if (chunk == 0) chunks.json = {reinterpret_cast<const char*>(content.data()), content.size()};
        if (chunk == 1 && readU32(bytes, offset + 4) == kChunkBinary) chunks.binary = content;
        offset += 8 + chunkLength;
    }
    return chunks;
}

// Parsers and visitors recurse by nesting depth; no sensible document comes near the limit.
bool nestsTooDeep(std::string_view text)
{
    int depth = 0;
    bool inString = false;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (inString) {
            if (c == '\\') {
                ++i;
            } else if (c == '"') {
                inString = false;
            }
        } else if (c == '"') {
            inString = true;
        } else if (c == '{' || c == '[') {
            if (++depth > kMaxJsonDepth) return true;
        } else if (c == '}' || c == ']') {
            --depth;
        }
    }
    return false;
}

std::string firstSentence(std::string text)
{
    text = text.substr(0, std::min(text.find('\n'), std::size_t(300))); // some quote a data: URI
    while (!text.empty() && (text.back() == '.' || text.back() == ' ')) text.pop_back();
    return text.empty() ? "the file cannot be read as glTF" : text;
}

// The data of each buffer: at least as long as byteLength in its file (glTF 2.0, section 3.6.1.1), cut to that here.
Status loadBuffers(SourceDocument& document, std::span<const std::byte> binary, std::vector<tinygltf::Buffer>& buffers)
{
    if (member(document.json, "buffers").is_null()) return {};
    Json& list = document.json["buffers"];
    uint64_t sum = 0;
    for (std::size_t i = 0; i < list.size(); ++i) {
        sum += isFallbackBuffer(list[i]) ? 0 : list[i]["byteLength"].get<uint64_t>();
        if (sum <= kMaxFileBytes) continue;
        return Error{ErrorCode::Unsupported, "buffers of 4 GiB and more in all are not supported",
                     pathOf("buffers", i)};
    }
    for (std::size_t i = 0; i < list.size(); ++i) {
        const auto length = list[i]["byteLength"].get<uint64_t>();
        const std::string path = pathOf("buffers", i);
        tinygltf::Buffer& buffer = buffers.emplace_back();
        if (isFallbackBuffer(list[i])) continue; // decompress() fills its place
        std::vector<std::byte> read;
        std::span<const std::byte> bytes = binary;
        if (const Json& uri = member(list[i], "uri"); !uri.is_null()) {
            const auto& text = uri.get_ref<const std::string&>();
            auto result = readUri(text, document.directory, length);
            if (!result) return Error{result.error().code, result.error().message, path};
            read = std::move(*result);
            bytes = read;
            if (!isDataUri(text)) document.bufferUris.push_back(text);
            list[i].erase("uri"); // may be megabytes of base64
        }
        if (bytes.size() < length) {
            return invalid(path, "byteLength is " + std::to_string(length) + ", but it holds " +
                                     std::to_string(bytes.size()) + " bytes");
        }
        const auto* first = reinterpret_cast<const unsigned char*>(bytes.data());
        buffer.data.assign(first, first + length);
    }
    return {};
}

// tinygltf's typed view of the JSON. Buffers and images are read by this program: tinygltf would wait for pipes, and
// decode URIs of HTML forms.
Status readTypedView(SourceDocument& document, std::vector<tinygltf::Buffer> buffers)
{
    Json& json = document.json;
    Json bufferJson;
    Json imageJson;
    const auto exchange = [&] {
        for (const auto& [key, value] : {std::pair("buffers", &bufferJson), std::pair("images", &imageJson)}) {
            Json kept = std::move(*value);
            *value = member(json, key).is_null() ? Json() : std::move(json[key]);
            json.erase(key);
            if (!kept.is_null()) json[key] = std::move(kept);
        }
    };
    exchange();
    const std::string text = json.dump();
    exchange();
    tinygltf::TinyGLTF loader;
    std::string error;
    std::string warning;
    if (!loader.LoadASCIIFromString(&document.model, &error, &warning, text.data(), unsigned(text.size()), ".",
                                    tinygltf::NO_REQUIRE)) {
        return Error{ErrorCode::FileInvalid, firstSentence(error)};
    }
    document.model.buffers = std::move(buffers);
    for (const Json& image : member(json, "images")) {
        tinygltf::Image& typed = document.model.images.emplace_back();
        const auto text = [&](const char* key) {
            const Json& value = member(image, key);
            return value.is_string() ? value.get<std::string>() : std::string();
        };
        typed.name = text("name");
        typed.mimeType = text("mimeType");
        typed.uri = text("uri");
        if (const Json& view = member(image, "bufferView"); !view.is_null()) typed.bufferView = view.get<int>();
    }
    // EXT_texture_webp names the image to prefer over the texture's own, which is for programs without WebP.
    for (std::size_t i = 0; readsCompression("EXT_texture_webp") && i < document.model.textures.size(); ++i) {
        const Json& source = member(extensionOf(json["textures"][i], "EXT_texture_webp"), "source");
        if (source.is_null()) continue;
        if (!source.is_number_unsigned() || source.get<uint64_t>() >= document.model.images.size())
            return invalid(pathOf("textures", i) + "/extensions/EXT_texture_webp", "source is not an image's index");
        document.model.textures[i].source = source.get<int>();
    }
    return {};
}

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

Result<std::shared_ptr<const SourceDocument>> parseDocument(std::span<const std::byte> bytes,
                                                            const std::filesystem::path& directory)
{
    if (bytes.size() > kMaxFileBytes) return Error{ErrorCode::Unsupported, "files of 4 GiB and more are not supported"};
    const auto chunks = chunksOf(bytes);
    if (!chunks) return chunks.error();
    if (nestsTooDeep(chunks->json))
        return Error{ErrorCode::FileInvalid, "the JSON is nested more than 128 levels deep"};

    auto document = std::make_shared<SourceDocument>();
    document->directory = directory;
    // Both libraries may throw: on syntax, on types that are not what they expect, when memory runs out.
    try {
        document->json = Json::parse(chunks->json.begin(), chunks->json.end());
    } catch (const std::exception& e) {
        const std::string what = e.what(); // "[json.exception.parse_error.101] parse error at line 1, …"
        const std::size_t at = what.find("] ");
        return Error{ErrorCode::FileInvalid, "the JSON is broken: " + what.substr(at == what.npos ? 0 : at + 2)};
    }
    try {
        markFallbackBuffers(document->json, !chunks->binary.empty());
        if (Status status = checkBeforeParsing(document->json, chunks->isBinary); !status) return status.error();
        std::vector<tinygltf::Buffer> buffers;
        if (Status s = loadBuffers(*document, chunks->binary, buffers); !s) return s.error();
        if (Status s = decompress(document->json, buffers); !s) return s.error();
        if (Status s = readTypedView(*document, std::move(buffers)); !s) return s.error();
    } catch (const std::exception&) {
        return Error{ErrorCode::FileInvalid, "the file cannot be read as glTF, or there is too little memory for it"};
    }
    if (Status status = checkAfterParsing(*document); !status) return status.error();
    if (Status status = checkFiniteAccessors(*document); !status) return status.error();
    stripEarlierBake(*document);
    return std::shared_ptr<const SourceDocument>(std::move(document));
}

Result<std::shared_ptr<const SourceDocument>> loadDocument(const std::filesystem::path& path)
{
    std::error_code ec;
    if (const auto size = std::filesystem::file_size(path, ec); !ec && size > kMaxFileBytes)
        return Error{ErrorCode::Unsupported, "files of 4 GiB and more are not supported"};
    const auto bytes = readFile(path);
    if (!bytes) return bytes.error();
    return parseDocument(*bytes, path.parent_path());
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
