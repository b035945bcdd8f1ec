#include "scene/load/load_document.h"

#include "halflight/base/file.h"
#include "scene/document/decode/compression.h"
#include "scene/document/decode/decompress.h"
#include "scene/document/fallback_buffers.h"
#include "scene/document/uri.h"
#include "scene/format/strip.h"
#include "scene/load/finite_accessors.h"
#include "scene/load/validate.h"

namespace halflight {
namespace {

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

} // namespace

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

} // namespace halflight
