// std::filesystem::path takes text as UTF-8: libstdc++ hands it to mbrtowc(), one character at a time, and the linker
// turns those calls into calls of this function (-Wl,--wrap=mbrtowc).

#include <cstddef>
#include <cstdint>
#include <cwchar>

namespace {

constexpr auto kInvalid = std::size_t(-1);
constexpr auto kIncomplete = std::size_t(-2);

/// Bytes of the sequence that begins so (RFC 3629); 0 where none does.
std::size_t sequenceLength(uint32_t first)
{
    if (first < 0x80) return 1;
    if (first < 0xC2 || first > 0xF4) return 0;
    return first < 0xE0 ? 2 : first < 0xF0 ? 3 : 4;
}

} // namespace

// Characters beyond 16 bits are two of Windows': the first call takes three of their four bytes and keeps the second
// half in the state, the next call takes the last byte.
extern "C" std::size_t __wrap_mbrtowc(wchar_t* wide, const char* text, std::size_t count, mbstate_t* state)
{
    if (text == nullptr) return 0;
    if (count == 0) return kIncomplete;
    const auto byte = [&](std::size_t i) { return uint32_t(static_cast<unsigned char>(text[i])); };
    if (state != nullptr && *state != 0) {
        const uint32_t low = uint32_t(*state) | (byte(0) & 0x3F);
        *state = 0;
        if (wide != nullptr) *wide = wchar_t(low);
        return 1;
    }
    const std::size_t length = sequenceLength(byte(0));
    if (length == 0) return kInvalid;
    if (count < length) return kIncomplete;
    uint32_t code = length == 1 ? byte(0) : byte(0) & (0x7Fu >> length);
    for (std::size_t i = 1; i < length; ++i) {
        if ((byte(i) & 0xC0) != 0x80) return kInvalid;
        code = code << 6 | (byte(i) & 0x3F);
    }
    constexpr uint32_t kLeast[] = {0, 0, 0x80, 0x800, 0x10000}; // shorter sequences exist below
    if (code < kLeast[length] || code > 0x10FFFF || (code >= 0xD800 && code < 0xE000)) return kInvalid;
    if (length < 4) {
        if (wide != nullptr) *wide = wchar_t(code);
        return code == 0 ? 0 : length;
    }
    if (state == nullptr) return kInvalid;
    if (wide != nullptr) *wide = wchar_t(0xD800 + ((code - 0x10000) >> 10));
    *state = mbstate_t(0xDC00 | (code & 0x3C0)); // without the last byte's six bits
    return 3;
}
