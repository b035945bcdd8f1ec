// KTX2 and Radiance files, by field offsets of their specifications and by reading them back.

#include "encode_rgbe.h"
#include "scene/pictures/ktx2.h"
#include "scene/pictures/rgbe.h"

#include "halflight/shading/random.h"

#include <cmath>
#include <cstring>
#include <glm/gtc/packing.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zstd.h>

namespace halflight::ktx2_test {
namespace {

Image<uint32_t> picture(int width, int height)
{
    Image<uint32_t> image(width, height);
    for (std::size_t i = 0; i < image.texelCount(); ++i) {
        const float scale = std::exp2(20.0f * unitFloat(hashPcg(uint32_t(i / 7))) - 12.0f);
        image.texels()[i] = glm::packF3x9_E1x5(
            scale * vec3(unitFloat(hashCombine(uint32_t(i / 3), 1)), unitFloat(hashCombine(uint32_t(i / 3), 2)), 1.0f));
    }
    return image;
}

uint32_t u32(const std::vector<std::byte>& bytes, std::size_t offset)
{
    uint32_t value = 0;
    std::memcpy(&value, bytes.data() + offset, 4);
    return value;
}
uint64_t u64(const std::vector<std::byte>& bytes, std::size_t offset)
{
    return u32(bytes, offset) | uint64_t(u32(bytes, offset + 4)) << 32;
}

// KTX 2.0 specification, section 3: the header's fields by byte offset.
TEST(Ktx2, FieldsAreWhereTheSpecificationPutsThem)
{
    const auto image = picture(37, 11);
    const auto file = encodeKtx2(image);
    ASSERT_TRUE(file);
    EXPECT_EQ(std::memcmp(file->data(), "\xABKTX 20\xBB\r\n\x1A\n", 12), 0);
    EXPECT_EQ(u32(*file, 12), 123u); // VK_FORMAT_E5B9G9R9_UFLOAT_PACK32
    EXPECT_EQ(u32(*file, 16), 4u);   // typeSize
    EXPECT_EQ(u32(*file, 20), 37u);
    EXPECT_EQ(u32(*file, 24), 11u);
    EXPECT_EQ(u32(*file, 28), 0u); // pixelDepth
    EXPECT_EQ(u32(*file, 32), 0u); // layerCount
    EXPECT_EQ(u32(*file, 36), 1u); // faceCount
    EXPECT_EQ(u32(*file, 40), 1u); // levelCount
    EXPECT_EQ(u32(*file, 44), 2u); // Zstandard
    const uint32_t dfd = u32(*file, 48);
    EXPECT_EQ(dfd, 104u);
    EXPECT_EQ(u32(*file, 52), 4u + 24u + 6u * 16u);
    EXPECT_EQ(u32(*file, 56), dfd + u32(*file, 52)); // key/value data follow
    EXPECT_EQ(u32(*file, 56) % 4, 0u);
    EXPECT_EQ(u64(*file, 64), 0u); // no supercompression global data
    EXPECT_EQ(u64(*file, 72), 0u);
    EXPECT_EQ(u64(*file, 80) + u64(*file, 88), file->size());
    EXPECT_EQ(u64(*file, 96), 37u * 11u * 4u);

    // Data format descriptor: six samples that cover all 32 bits, the exponent shared.
    EXPECT_EQ(u32(*file, dfd), u32(*file, 52));
    EXPECT_EQ(u32(*file, dfd + 4), 0u);
    EXPECT_EQ(u32(*file, dfd + 8) & 0xffff, 2u);
    EXPECT_EQ(u32(*file, dfd + 8) >> 16, 24u + 6u * 16u);
    EXPECT_EQ(u32(*file, dfd + 12), 0x00010101u); // RGBSDA, BT.709, linear
    EXPECT_EQ(u32(*file, dfd + 20), 4u);          // bytesPlane0
    uint32_t mantissaBits = 0;
    for (uint32_t s = 0; s < 6; ++s) {
        const uint32_t word = u32(*file, dfd + 28 + 16 * s);
        const uint32_t offset = word & 0xffff;
        const uint32_t length = (word >> 16 & 0xff) + 1;
        const uint32_t type = word >> 24;
        EXPECT_EQ(type & 0xf, s / 2);
        if (s % 2 == 0) {
            EXPECT_EQ(type >> 4, 0u);
            mantissaBits |= ((1u << length) - 1) << offset;
            EXPECT_EQ(u32(*file, dfd + 28 + 16 * s + 12), 8448u);
        } else {
            EXPECT_EQ(type >> 4, 2u); // exponent
            EXPECT_EQ(offset, 27u);
            EXPECT_EQ(length, 5u);
            EXPECT_EQ(u32(*file, dfd + 28 + 16 * s + 8), 15u);
            EXPECT_EQ(u32(*file, dfd + 28 + 16 * s + 12), 31u);
        }
    }
    EXPECT_EQ(mantissaBits, 0x07ffffffu);
    EXPECT_EQ(u32(*file, u32(*file, 56)), 20u); // length of "KTXwriter\0Halflight\0"

    std::vector<uint32_t> raw(37 * 11);
    ASSERT_EQ(ZSTD_decompress(raw.data(), raw.size() * 4, file->data() + u64(*file, 80), u64(*file, 88)),
              raw.size() * 4);
    EXPECT_EQ(raw, image.texels());
}

TEST(Ktx2, ReadsBackAndRefusesDamage)
{
    for (const auto& [w, h] : {std::pair{1, 1}, {64, 64}, {300, 7}}) {
        const auto image = picture(w, h);
        const auto file = encodeKtx2(image);
        ASSERT_TRUE(file);
        const auto back = decodeKtx2(*file);
        ASSERT_TRUE(back) << back.error().text();
        EXPECT_EQ(back->texels(), image.texels());
        EXPECT_EQ(back->size(), image.size());
    }
    const auto file = encodeKtx2(picture(16, 16));
    ASSERT_TRUE(file);
    for (std::size_t n = 0; n < file->size(); n += 5) EXPECT_FALSE(decodeKtx2(std::span(*file).first(n))) << n;
    for (const std::size_t offset : {0u, 12u, 20u, 25u, 36u, 44u, 84u, 96u}) {
        auto damaged = *file;
        damaged[offset] ^= std::byte(0x41);
        EXPECT_FALSE(decodeKtx2(damaged)) << offset;
    }
}

// A decoder after Ward's description, independent of the encoder.
std::vector<vec3> decodeRgbe(const std::vector<std::byte>& file, int width, int height)
{
    std::string text(reinterpret_cast<const char*>(file.data()), file.size());
    std::size_t at = text.find("\n\n");
    EXPECT_EQ(text.rfind("#?RADIANCE\n", 0), 0u);
    at = text.find('\n', at + 2) + 1;
    const auto next = [&] { return at < text.size() ? uint8_t(text[at++]) : uint8_t(0); };
    std::vector<vec3> pixels;
    for (int y = 0; y < height; ++y) {
        std::vector<std::array<uint8_t, 4>> row(std::size_t(width), std::array<uint8_t, 4>{});
        if (width < 8) {
            for (auto& texel : row) {
                for (auto& c : texel) c = next();
            }
        } else {
            EXPECT_EQ(next(), 2);
            EXPECT_EQ(next(), 2);
            const int high = next();
            EXPECT_EQ(high * 256 + next(), width);
            for (std::size_t c = 0; c < 4; ++c) {
                for (std::size_t x = 0; x < row.size() && at < text.size();) {
                    const int n = next();
                    EXPECT_NE(n, 0);
                    if (n > 128) {
                        const uint8_t value = next();
                        for (int k = 0; k < n - 128 && x < row.size(); ++k) row[x++][c] = value;
                    } else {
                        for (int k = 0; k < n && x < row.size(); ++k) row[x++][c] = next();
                    }
                }
            }
        }
        for (const auto& t : row)
            pixels.push_back(t[3] == 0 ? vec3(0) : vec3(t[0], t[1], t[2]) * std::ldexp(1.0f, int(t[3]) - 136));
    }
    EXPECT_EQ(at, text.size());
    return pixels;
}

TEST(Rgbe, MatchesTheLightmapToHalfAStep)
{
    for (const auto& [w, h] : {std::pair{3, 5}, {8, 2}, {200, 9}}) {
        const auto image = picture(w, h);
        const auto pixels = decodeRgbe(encodeRgbe(image), w, h);
        ASSERT_EQ(pixels.size(), image.texelCount());
        for (std::size_t i = 0; i < pixels.size(); ++i) {
            const vec3 truth = glm::unpackF3x9_E1x5(image.texels()[i]);
            const float largest = std::max({truth.x, truth.y, truth.z});
            const float step = largest / 128.0f; // eight bits, the first of them set
            for (int c = 0; c < 3; ++c) EXPECT_NEAR(pixels[i][c], truth[c], 0.51f * step);
        }
    }
    const auto black = decodeRgbe(encodeRgbe(Image<uint32_t>(300, 2)), 300, 2);
    for (const vec3& p : black) EXPECT_EQ(p, vec3(0.0f));
}

} // namespace
} // namespace halflight::ktx2_test
