#include "scene/document/uri.h"

#include "halflight/base/file.h"

#include <algorithm>
#include <array>

namespace halflight {

namespace {

int hexDigit(char c)
{
    return c >= '0' && c <= '9' ? c - '0' : (c | 32) >= 'a' && (c | 32) <= 'f' ? (c | 32) - 'a' + 10 : -1;
}

bool equalsIgnoringCase(std::string_view a, std::string_view b)
{
    const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? char(c + 32) : c; };
    return a.size() == b.size() &&
           std::equal(a.begin(), a.end(), b.begin(), [&](char x, char y) { return lower(x) == lower(y); });
}

// RFC 4648: the standard alphabet, and the one for URLs ('-' and '_'). Line breaks and blanks are skipped.
Result<std::vector<std::byte>> decodeBase64(std::string_view text)
{
    std::vector<std::byte> bytes;
    bytes.reserve(text.size() / 4 * 3 + 3);
    uint32_t bits = 0;
    int bitCount = 0;
    bool padded = false;
    for (const char c : text) {
        if (c == ' ' || c == '\t' || c == '\r' || c == '\n') continue;
        if (c == '=') {
            padded = true;
            continue;
        }
        const int value = c >= 'A' && c <= 'Z'   ? c - 'A'
                          : c >= 'a' && c <= 'z' ? c - 'a' + 26
                          : c >= '0' && c <= '9' ? c - '0' + 52
                          : c == '+' || c == '-' ? 62
                          : c == '/' || c == '_' ? 63
                                                 : -1;
        if (value < 0 || padded) return Error{ErrorCode::FileInvalid, "the data: URI is not valid base64"};
        bits = bits << 6 | uint32_t(value);
        bitCount += 6;
        if (bitCount >= 8) {
            bitCount -= 8;
            bytes.push_back(std::byte(bits >> bitCount & 0xff));
        }
    }
    return bytes;
}

// "https" of "https://…"; empty where the text is a path. One letter is a drive of Windows, no scheme.
std::string_view schemeOf(std::string_view uri)
{
    const std::size_t colon = uri.find("://");
    if (colon == std::string_view::npos || colon < 2) return {};
    const std::string_view scheme = uri.substr(0, colon);
    const bool good = std::all_of(scheme.begin(), scheme.end(), [](char c) {
        return (c >= '0' && c <= '9') || ((c | 32) >= 'a' && (c | 32) <= 'z') || c == '+' || c == '-' || c == '.';
    });
    return good ? scheme : std::string_view();
}

} // namespace

std::string percentDecoded(std::string_view uri)
{
    std::string text;
    for (std::size_t i = 0; i < uri.size(); ++i) {
        if (uri[i] == '%' && i + 2 < uri.size() && hexDigit(uri[i + 1]) >= 0 && hexDigit(uri[i + 2]) >= 0) {
            text += char(hexDigit(uri[i + 1]) * 16 + hexDigit(uri[i + 2]));
            i += 2;
        } else {
            text += uri[i];
        }
    }
    return text;
}

std::string percentEncoded(std::string_view name)
{
    constexpr std::string_view kDigits = "0123456789ABCDEF";
    std::string uri;
    for (const char c : name) {
        const auto byte = static_cast<unsigned char>(c);
        const bool letter = (byte | 32) >= 'a' && (byte | 32) <= 'z';
        const bool digit = byte >= '0' && byte <= '9';
        if (letter || digit || c == '-' || c == '.' || c == '_' || c == '~') {
            uri += c;
        } else {
            uri += {'%', kDigits[byte >> 4], kDigits[byte & 15]};
        }
    }
    return uri;
}

bool isDataUri(std::string_view uri)
{
    return equalsIgnoringCase(uri.substr(0, 5), "data:");
}

Result<std::vector<std::byte>> decodeDataUri(std::string_view uri)
{
    const std::size_t comma = uri.find(',');
    if (!isDataUri(uri) || comma == std::string_view::npos) {
        return Error{ErrorCode::FileInvalid, "the data: URI has no comma before its data"};
    }
    const std::string_view header = uri.substr(5, comma - 5);
    const std::string_view data = uri.substr(comma + 1);
    const std::size_t last = header.rfind(';');
    const bool isBase64 = last != std::string_view::npos && equalsIgnoringCase(header.substr(last + 1), "base64");
    if (isBase64) {
        return data.find('%') == std::string_view::npos ? decodeBase64(data) : decodeBase64(percentDecoded(data));
    }
    const std::string text = percentDecoded(data);
    const auto* first = reinterpret_cast<const std::byte*>(text.data());
    return std::vector<std::byte>(first, first + text.size());
}

Result<std::vector<std::byte>> readUri(std::string_view uri, const std::filesystem::path& directory,
                                       uint64_t firstBytes)
{
    if (isDataUri(uri)) return decodeDataUri(uri);
    if (uri.empty()) return Error{ErrorCode::FileInvalid, "uri is empty"};
    const std::string decoded = percentDecoded(uri);
    if (decoded.find('\0') != std::string::npos) {
        return Error{ErrorCode::FileInvalid, "uri names a file with a zero byte in its name"};
    }
    if (const std::string_view scheme = schemeOf(uri); !scheme.empty()) {
        return Error{ErrorCode::Unsupported, "uri has the scheme " + std::string(scheme) +
                                                 "; only data: URIs and files beside the document are read"};
    }
    // A name is also tried as it stands, for files that an exporter named without percent-encoding.
    auto bytes = readFile(directory / decoded, firstBytes);
    std::error_code ec;
    if (!bytes && decoded != uri && !std::filesystem::exists(directory / decoded, ec)) {
        if (auto asItStands = readFile(directory / std::string(uri), firstBytes)) return asItStands;
    }
    if (!bytes) return Error{bytes.error().code, "file " + decoded + " cannot be read: " + bytes.error().message};
    return bytes;
}

} // namespace halflight
