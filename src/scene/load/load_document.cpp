#include "scene/load/load_document.h"

#include "halflight/base/file.h"
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

// The data of each buffer: at least as long as byteLength in its file (glTF 2.0, section 3.6.1.1), cut to that here.
Status loadBuffers(SourceDocument& document, std::span<const std::byte> binary)
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
        std::vector<std::byte>& buffer = document.buffers.emplace_back();
        if (isFallbackBuffer(list[i])) continue; // decompress() fills its place
        std::size_t held = binary.size();
        if (const Json& uri = member(list[i], "uri"); !uri.is_null()) {
            const auto& text = uri.get_ref<const std::string&>();
            auto result = readUri(text, document.directory, length);
            if (!result) return Error{result.error().code, result.error().message, path};
            buffer = std::move(*result);
            held = buffer.size();
            if (!isDataUri(text)) document.bufferUris.push_back(text);
            list[i].erase("uri"); // may be megabytes of base64
        }
        if (held < length) {
            return invalid(path, "byteLength is " + std::to_string(length) + ", but it holds " + std::to_string(held) +
                                     " bytes");
        }
        if (buffer.empty()) buffer.assign(binary.begin(), binary.begin() + std::ptrdiff_t(length));
        buffer.resize(std::size_t(length));
    }
    return {};
}

// Fills a document whose JSON is parsed.
Status readParsed(SourceDocument& document, const Chunks& chunks)
{
    markFallbackBuffers(document.json, !chunks.binary.empty());
    if (Status s = checkPacked(document.json, chunks.isBinary); !s) return s;
    if (Status s = loadBuffers(document, chunks.binary); !s) return s;
    if (Status s = decompress(document.json, document.buffers); !s) return s;
    if (Status s = checkUnpacked(document); !s) return s;
    return checkFiniteAccessors(document);
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
    // The library may throw: on syntax, on types that are not what is asked for, when memory runs out.
    try {
        document->json = Json::parse(chunks->json.begin(), chunks->json.end());
    } catch (const std::exception& e) {
        const std::string what = e.what(); // "[json.exception.parse_error.101] parse error at line 1, …"
        const std::size_t at = what.find("] ");
        return Error{ErrorCode::FileInvalid, "the JSON is broken: " + what.substr(at == what.npos ? 0 : at + 2)};
    }
    try {
        if (Status status = readParsed(*document, *chunks); !status) return status.error();
    } catch (const std::exception&) {
        return Error{ErrorCode::FileInvalid, "the file cannot be read as glTF, or there is too little memory for it"};
    }
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
