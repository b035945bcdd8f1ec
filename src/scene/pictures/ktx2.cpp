#include "scene/pictures/ktx2.h"

#include "halflight/base/parallel.h"
#include "halflight/base/rgb9e5.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstring>
#include <glm/gtc/packing.hpp>
#include <string>
#include <string_view>
#include <zstd.h>

namespace halflight {

namespace {

constexpr std::array<uint8_t, 12> kIdentifier = {0xAB, 0x4B, 0x54, 0x58, 0x20, 0x32,
                                                 0x30, 0xBB, 0x0D, 0x0A, 0x1A, 0x0A};
constexpr uint32_t kFormatE5B9G9R9 = 123; // VK_FORMAT_E5B9G9R9_UFLOAT_PACK32
constexpr uint32_t kFormatHalf = 97;      // VK_FORMAT_R16G16B16A16_SFLOAT
constexpr uint32_t kSchemeNone = 0;
constexpr uint32_t kSchemeZstandard = 2;
constexpr std::size_t kHeaderBytes = 80;
constexpr std::size_t kLevelBytes = 24;
constexpr uint32_t kMaxSide = 16384;

class KtxBytes {
public:
    void u32(uint32_t value)
    {
        for (int i = 0; i < 4; ++i) bytes_.push_back(std::byte(value >> (8 * i) & 0xff));
    }
    void u64(uint64_t value)
    {
        u32(uint32_t(value));
        u32(uint32_t(value >> 32));
    }
    void text(std::string_view value)
    {
        for (const char c : value) bytes_.push_back(std::byte(c));
    }
    void pad(std::size_t alignment)
    {
        while (bytes_.size() % alignment != 0) bytes_.push_back(std::byte(0));
    }
    std::vector<std::byte>& get() { return bytes_; }

private:
    std::vector<std::byte> bytes_;
};

// The head of a basic data format descriptor (Khronos Data Format Specification 1.3, section 5) with so many samples.
void putDescriptorHead(KtxBytes& d, uint32_t samples, uint32_t texelBytes)
{
    const uint32_t blockBytes = 24 + 16 * samples;
    d.u32(4 + blockBytes);
    d.u32(0);                              // vendor Khronos, basic descriptor
    d.u32(2 | blockBytes << 16);           // version 1.3
    d.u32(1 | 1 << 8 | 1 << 16 | 0 << 24); // RGBSDA, BT.709 primaries, linear, straight alpha
    d.u32(0);                              // one texel per block
    d.u32(texelBytes);                     // of plane 0
    d.u32(0);
}

// Of a shared-exponent format, after that specification's example "R9G9B9E5": a mantissa and an exponent sample for
// each channel. sampleUpper of a mantissa is the value of 1.0 scaled by the exponent's range, 8448; the exponent's bias
// is 15 and its largest value 31.
std::vector<std::byte> rgb9e5Descriptor()
{
    constexpr uint32_t kQualifierExponent = 0x20;
    KtxBytes d;
    putDescriptorHead(d, 6, sizeof(uint32_t));
    for (uint32_t channel = 0; channel < 3; ++channel) {
        d.u32(9 * channel | (9 - 1) << 16 | channel << 24);
        d.u32(0);
        d.u32(0);
        d.u32(8448);
        d.u32(27 | (5 - 1) << 16 | (channel | kQualifierExponent) << 24);
        d.u32(0);
        d.u32(15);
        d.u32(31);
    }
    return std::move(d.get());
}

// Of four signed half floats; lower and upper are -1 and 1 as floats.
std::vector<std::byte> halfDescriptor()
{
    constexpr uint32_t kSignedFloat = 0xC0;
    KtxBytes d;
    putDescriptorHead(d, 4, sizeof(uint64_t));
    for (const uint32_t channel : {0u, 1u, 2u, 15u}) { // 15 is alpha
        const uint32_t offset = channel == 15 ? 48 : 16 * channel;
        d.u32(offset | (16 - 1) << 16 | (channel | kSignedFloat) << 24);
        d.u32(0);
        d.u32(0xBF800000);
        d.u32(0x3F800000);
    }
    return std::move(d.get());
}

std::vector<std::byte> keyValueData()
{
    constexpr std::string_view kEntry("KTXwriter\0Halflight\0", 20);
    KtxBytes d;
    d.u32(uint32_t(kEntry.size()));
    d.text(kEntry);
    d.pad(4);
    return std::move(d.get());
}

uint64_t load(std::span<const std::byte> bytes, std::size_t offset, int count)
{
    uint64_t value = 0;
    for (int i = count - 1; i >= 0; --i) value = value << 8 | uint64_t(bytes[offset + std::size_t(i)]);
    return value;
}

// The level's texels; false where it is damaged.
bool unpackLevel(std::span<const std::byte> level, uint32_t scheme, std::span<std::byte> texels)
{
    if (scheme == kSchemeZstandard)
        return ZSTD_decompress(texels.data(), texels.size(), level.data(), level.size()) == texels.size();
    std::memcpy(texels.data(), level.data(), texels.size());
    return true;
}

Error broken(const char* what)
{
    return Error{ErrorCode::FileInvalid, std::string("the KTX2 image is not readable: ") + what, ""};
}

struct Level {
    uint32_t format;
    uint32_t typeBytes;
    ivec2 size;
    std::span<const std::byte> texels;
    std::vector<std::byte> descriptor;
};

Result<std::vector<std::byte>> encode(const Level& level, int zstdLevel)
{
    const std::size_t rawBytes = level.texels.size();
    std::vector<std::byte> compressed(ZSTD_compressBound(rawBytes));
    const std::size_t size =
        ZSTD_compress(compressed.data(), compressed.size(), level.texels.data(), rawBytes, zstdLevel);
    if (ZSTD_isError(size)) {
        return Error{ErrorCode::WriteFailed, std::string("Zstandard failed: ") + ZSTD_getErrorName(size), ""};
    }
    const auto keyValues = keyValueData();
    const std::size_t descriptorOffset = kHeaderBytes + kLevelBytes;
    const std::size_t keyValueOffset = descriptorOffset + level.descriptor.size();
    const std::size_t dataOffset = keyValueOffset + keyValues.size(); // compressed levels need no alignment

    KtxBytes file;
    for (const uint8_t b : kIdentifier) file.get().push_back(std::byte(b));
    for (const uint32_t v : {level.format, level.typeBytes, uint32_t(level.size.x), uint32_t(level.size.y), 0u, 0u, 1u,
                             1u, kSchemeZstandard}) {
        file.u32(v); // format, type size, width, height, depth, layers, faces, levels, scheme
    }
    file.u32(uint32_t(descriptorOffset));
    file.u32(uint32_t(level.descriptor.size()));
    file.u32(uint32_t(keyValueOffset));
    file.u32(uint32_t(keyValues.size()));
    file.u64(0); // no supercompression global data
    file.u64(0);
    file.u64(dataOffset);
    file.u64(size);
    file.u64(rawBytes);
    auto& bytes = file.get();
    bytes.insert(bytes.end(), level.descriptor.begin(), level.descriptor.end());
    bytes.insert(bytes.end(), keyValues.begin(), keyValues.end());
    assert(bytes.size() == dataOffset);
    bytes.insert(bytes.end(), compressed.begin(), compressed.begin() + std::ptrdiff_t(size));
    return std::move(bytes);
}

} // namespace

Result<std::vector<std::byte>> encodeKtx2(const Image<uint32_t>& image, int zstdLevel)
{
    assert(!image.empty());
    return encode(
        {kFormatE5B9G9R9, sizeof(uint32_t), image.size(), std::as_bytes(std::span(image.texels())), rgb9e5Descriptor()},
        zstdLevel);
}

Result<std::vector<std::byte>> encodeKtx2(const Image<uint64_t>& half, int zstdLevel)
{
    assert(!half.empty());
    return encode(
        {kFormatHalf, sizeof(uint16_t), half.size(), std::as_bytes(std::span(half.texels())), halfDescriptor()},
        zstdLevel);
}

Image<uint64_t> halfTexels(const ImageRgb32f& page)
{
    constexpr float kMaxHalf = 65504.0f;
    Image<uint64_t> half(page.width(), page.height());
    forEachIndex(half.texelCount(), [&](std::size_t i) {
        half.texels()[i] = glm::packHalf4x16(vec4(glm::clamp(page.texels()[i], 0.0f, kMaxHalf), 1.0f));
    });
    return half;
}

vec3 floatsOf(uint64_t half)
{
    return {glm::unpackHalf4x16(half)};
}

void roundMantissas(Image<uint32_t>& image, int bits)
{
    assert(bits >= 1 && bits <= 9);
    const uint32_t step = 1u << (9 - bits);
    for (uint32_t& texel : image.texels()) {
        uint32_t rounded = texel & 0xf8000000u;
        for (int shift = 0; shift < 27; shift += 9) {
            const uint32_t mantissa = (texel >> shift & 511u) + step / 2;
            rounded |= std::min(mantissa - mantissa % step, 512u - step) << shift;
        }
        texel = rounded;
    }
}

Result<Image<uint32_t>> decodeKtx2(std::span<const std::byte> bytes)
{
    if (bytes.size() < kHeaderBytes + kLevelBytes) return broken("it is too short");
    if (std::memcmp(bytes.data(), kIdentifier.data(), kIdentifier.size()) != 0)
        return broken("it has the wrong identifier");
    const auto field = [&](std::size_t index) { return uint32_t(load(bytes, 12 + 4 * index, 4)); };
    const bool isHalf = field(0) == kFormatHalf;
    if (!isHalf && field(0) != kFormatE5B9G9R9)
        return broken("its format is neither E5B9G9R9_UFLOAT_PACK32 nor R16G16B16A16_SFLOAT");
    const uint32_t width = field(2);
    const uint32_t height = field(3);
    if (width == 0 || height == 0 || width > kMaxSide || height > kMaxSide) return broken("its size is out of range");
    if (field(4) > 1 || field(5) > 1 || field(6) != 1 || field(7) != 1)
        return broken("it is not one plain two-dimensional level");
    const uint32_t scheme = field(8);
    const uint64_t offset = load(bytes, kHeaderBytes, 8);
    const uint64_t size = load(bytes, kHeaderBytes + 8, 8);
    const uint64_t rawBytes = uint64_t(width) * height * (isHalf ? sizeof(uint64_t) : sizeof(uint32_t));
    if (offset > bytes.size() || size > bytes.size() - offset) return broken("its level lies outside of it");
    if (load(bytes, kHeaderBytes + 16, 8) != rawBytes) return broken("its level has the wrong length");
    if (scheme == kSchemeNone) {
        if (size != rawBytes) return broken("its level has the wrong length");
    } else if (scheme == kSchemeZstandard) {
        if (ZSTD_getFrameContentSize(bytes.data() + offset, size) != rawBytes)
            return broken("its compressed level has the wrong length");
    } else {
        return broken("its supercompression is not Zstandard");
    }
    const auto level = bytes.subspan(offset, size);
    Image<uint32_t> image{int(width), int(height)};
    if (!isHalf) {
        if (!unpackLevel(level, scheme, std::as_writable_bytes(std::span(image.texels()))))
            return broken("its compressed level is damaged");
        return image;
    }
    Image<uint64_t> half{int(width), int(height)};
    if (!unpackLevel(level, scheme, std::as_writable_bytes(std::span(half.texels()))))
        return broken("its compressed level is damaged");
    for (std::size_t i = 0; i < half.texelCount(); ++i) image.texels()[i] = packRgb9e5(floatsOf(half.texels()[i]));
    return image;
}

} // namespace halflight
