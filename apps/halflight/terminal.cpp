#include "terminal.h"

#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>

namespace halflight::cli {

namespace {

// Length of the UTF-8 sequence at the start of `text` and its code point (RFC 3629); length 0 when it is not valid.
struct Decoded {
    std::size_t length = 0;
    uint32_t codePoint = 0;
};

Decoded decodeUtf8(std::string_view text)
{
    const auto byte = [&](std::size_t i) { return uint32_t(static_cast<unsigned char>(text[i])); };
    const uint32_t first = byte(0);
    if (first < 0x80) return {1, first};
    const std::size_t length = first >= 0xF0 && first < 0xF8 ? 4 : first >= 0xE0 ? 3 : first >= 0xC2 ? 2 : 0;
    if (length == 0 || first >= 0xF8 || text.size() < length) return {};
    uint32_t code = first & (0x7Fu >> length);
    for (std::size_t i = 1; i < length; ++i) {
        if ((byte(i) & 0xC0) != 0x80) return {};
        code = code << 6 | (byte(i) & 0x3F);
    }
    constexpr uint32_t kLeast[] = {0, 0, 0x80, 0x800, 0x10000}; // shorter sequences exist below
    const bool surrogate = code >= 0xD800 && code < 0xE000;
    if (code < kLeast[length] || code > 0x10FFFF || surrogate) return {};
    return {length, code};
}

bool steersTerminal(uint32_t code)
{
    const bool control = code < 0x20 || (code >= 0x7F && code < 0xA0);
    const bool separator = code == 0x2028 || code == 0x2029;
    const bool bidirectional = (code >= 0x202A && code <= 0x202E) || (code >= 0x2066 && code <= 0x2069);
    return control || separator || bidirectional;
}

std::string escaped(std::string_view text, bool keepLineBreaks)
{
    std::string result;
    result.reserve(text.size());
    while (!text.empty()) {
        const Decoded decoded = decodeUtf8(text);
        const std::size_t length = decoded.length > 0 ? decoded.length : 1;
        if (decoded.length == 0) {
            result += fmt::format("\\x{:02x}", static_cast<unsigned char>(text[0]));
        } else if (!steersTerminal(decoded.codePoint) || (keepLineBreaks && text[0] == '\n')) {
            result += text.substr(0, length);
        } else if (decoded.codePoint == '\n') {
            result += "\\n";
        } else {
            const bool ascii = decoded.codePoint < 0x80;
            result += ascii ? fmt::format("\\x{:02x}", decoded.codePoint) : fmt::format("\\u{:04x}", decoded.codePoint);
        }
        text.remove_prefix(length);
    }
    return result;
}

// Errors of standard output are sticky in its FILE, so finishResults() sees them all.
void writeResult(const std::string& text)
{
    std::fwrite(text.data(), 1, text.size(), stdout);
}

} // namespace

std::string printable(std::string_view text)
{
    return escaped(text, false);
}

void say(std::string_view text)
{
    std::fwrite(text.data(), 1, text.size(), stderr);
    std::fflush(stderr);
    std::clearerr(stderr);
}

void printText(std::string_view text)
{
    writeResult(escaped(text, true));
}

void printJson(std::string_view json)
{
    std::string text;
    text.reserve(json.size());
    while (!json.empty()) {
        const Decoded decoded = decodeUtf8(json);
        const std::size_t length = decoded.length > 0 ? decoded.length : 1;
        if (decoded.length > 0 && decoded.codePoint >= 0x7F && steersTerminal(decoded.codePoint)) {
            text += fmt::format("\\u{:04x}", decoded.codePoint);
        } else {
            text += json.substr(0, length);
        }
        json.remove_prefix(length);
    }
    writeResult(text + "\n");
}

Status finishResults()
{
    errno = 0;
    const bool failed = std::fflush(stdout) != 0 || std::ferror(stdout) != 0;
    if (!failed) return {};
    const std::string reason = errno != 0 ? fmt::format(" ({})", std::strerror(errno)) : std::string();
    return Error{ErrorCode::WriteFailed, "standard output cannot be written" + reason};
}

} // namespace halflight::cli
