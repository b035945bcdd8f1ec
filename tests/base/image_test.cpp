#include "base/temp_folder.h"
#include "halflight/base/file.h"
#include "halflight/base/image_filter.h"
#include "halflight/shading/random.h"

#include <algorithm>
#include <cstring>
#include <gtest/gtest.h>
#include <span>

namespace halflight::image_test {
namespace {

using test::TempFolder;

ImageRgba8 noise(int width, int height)
{
    ImageRgba8 image(width, height);
    for (std::size_t i = 0; i < image.texelCount(); ++i) {
        const uint32_t h = hashPcg(uint32_t(i));
        image.data()[i] = u8vec4(h, h >> 8, h >> 16, h >> 24);
    }
    return image;
}

/// A plane stays a plane between texel centres, which hold their own value; beyond the outer centres the edge goes on.
TEST(ImageFilter, BilinearIsExactOnPlanesAndClampsToTheEdge)
{
    ImageRgb32f image(5, 3);
    const auto plane = [](vec2 place) { return vec3(place.x, place.y, 2.0f * place.x - place.y + 1.0f); };
    for (int y = 0; y < 3; ++y) {
        for (int x = 0; x < 5; ++x) image(x, y) = plane(vec2(x, y) + 0.5f);
    }
    for (const vec2 place : {vec2(0.5f), vec2(1.5f, 2.5f), vec2(1.0f, 1.0f), vec2(3.25f, 0.9f), vec2(4.5f, 2.5f)})
        EXPECT_LT(glm::distance(bilinear(image, place), plane(place)), 1.0e-5f);
    EXPECT_EQ(bilinear(image, vec2(-7.0f, 1.5f)), image(0, 1));
    EXPECT_EQ(bilinear(image, vec2(5.0f, 9.0f)), image(4, 2));
    EXPECT_EQ(bilinear(ImageRgb32f(1, 1, vec3(3.0f)), vec2(0.2f, 0.9f)), vec3(3.0f));
}

TEST(ImagePng, RoundTripIsExact)
{
    const TempFolder folder;
    for (const ivec2 size : {ivec2(1, 1), ivec2(37, 5), ivec2(3, 64), ivec2(1, 1000), ivec2(700, 300)}) {
        const ImageRgba8 image = noise(size.x, size.y);
        ASSERT_TRUE(writePng(folder / "a.png", image));
        const auto read = readPng(folder / "a.png");
        ASSERT_TRUE(read) << read.error().text();
        ASSERT_EQ(read->size(), size);
        EXPECT_EQ(read->texels(), image.texels()) << "also where alpha is 0";
    }
    EXPECT_EQ(folder.fileCount(), 1u);
}

TEST(ImagePng, SameImageSameBytes)
{
    const auto a = encodePng(noise(64, 64));
    const auto b = encodePng(noise(64, 64));
    ASSERT_TRUE(a && b);
    EXPECT_EQ(*a, *b);
}

TEST(ImagePng, EmptyImageIsAnError)
{
    EXPECT_FALSE(encodePng(ImageRgba8()));
}

TEST(ImageExr, RoundTripKeepsFloats)
{
    const TempFolder folder;
    ImageRgba32f image(19, 7);
    for (std::size_t i = 0; i < image.texelCount(); ++i) {
        const float x = float(int(i) - 40);
        image.data()[i] = vec4(x, x * 1.0e5f, x / 3.0e4f, unitFloat(hashPcg(uint32_t(i))));
    }
    ASSERT_TRUE(writeExr(folder / "a.exr", image));
    const auto read = readExr(folder / "a.exr");
    ASSERT_TRUE(read) << read.error().text();
    ASSERT_EQ(read->size(), image.size());
    // Half floats carry 11 significant bits; values here are within their range, or written as full floats.
    for (std::size_t i = 0; i < image.texelCount(); ++i) {
        for (int c = 0; c < 4; ++c) {
            ASSERT_NEAR(read->data()[i][c], image.data()[i][c], 1e-7f + std::abs(image.data()[i][c]) / 1024.0f);
        }
    }
    EXPECT_EQ(folder.fileCount(), 1u);
}

TEST(ImageExr, ThreeChannelsReadWithAlphaOne)
{
    const TempFolder folder;
    ImageRgb32f image(4, 3, vec3(0.25f, 2.0f, 1000.0f));
    image(3, 0) = vec3(5, 6, 7); // top right
    ASSERT_TRUE(writeExr(folder / "a.exr", image));
    const auto read = readExr(folder / "a.exr");
    ASSERT_TRUE(read);
    EXPECT_EQ((*read)(0, 0), vec4(0.25f, 2.0f, 1000.0f, 1.0f));
    EXPECT_EQ((*read)(3, 0), vec4(5, 6, 7, 1)) << "rows and columns keep their order";
    EXPECT_EQ((*read)(3, 2), vec4(0.25f, 2.0f, 1000.0f, 1.0f));
}

TEST(ImageExr, ErrorsAreResults)
{
    const TempFolder folder;
    EXPECT_FALSE(readExr(folder / "missing.exr"));
    ASSERT_TRUE(writeFileAtomically(folder / "text.exr", "this is no picture"));
    const auto read = readExr(folder / "text.exr");
    ASSERT_FALSE(read);
    EXPECT_EQ(read.error().code, ErrorCode::FileInvalid);
    const Status status = writeExr((folder / "missing") / "a.exr", ImageRgb32f(2, 2));
    ASSERT_FALSE(status);
    EXPECT_EQ(status.error().code, ErrorCode::WriteFailed);
}

TEST(ImageExr, TruncatedFileIsAnError)
{
    const TempFolder folder;
    ASSERT_TRUE(writeExr(folder / "a.exr", ImageRgb32f(64, 64, vec3(0.3f))));
    const auto bytes = readFile(folder / "a.exr");
    ASSERT_TRUE(bytes);
    for (const std::size_t length :
         {bytes->size() / 2, bytes->size() / 4, std::size_t(100), std::size_t(8), std::size_t(3)}) {
        ASSERT_TRUE(writeFileAtomically(folder / "cut.exr", bytes->data(), length));
        EXPECT_FALSE(readExr(folder / "cut.exr")) << length << " bytes";
    }
}

/// A file may claim any size: it must be refused before memory is asked for.
TEST(ImageExr, ForgedSizeIsRefused)
{
    const TempFolder folder;
    ASSERT_TRUE(writeExr(folder / "a.exr", ImageRgb32f(4, 4, vec3(0.3f))));
    auto bytes = readFile(folder / "a.exr");
    ASSERT_TRUE(bytes);
    // The attribute "dataWindow", type "box2i", size 16: xMin yMin xMax yMax as little-endian 32-bit integers.
    const std::string name("dataWindow\0box2i\0", 17);
    const std::string_view text(reinterpret_cast<const char*>(bytes->data()), bytes->size());
    const std::size_t at = text.find(name);
    ASSERT_NE(at, std::string_view::npos);
    for (const ivec4 window :
         {ivec4(0, 0, 0x3fffffff, 0x3fffffff), ivec4(0, 0, 60000, 60000), ivec4(0, 0, 100, 2000000000),
          ivec4(std::numeric_limits<int>::min(), 0, std::numeric_limits<int>::max(), 3)}) {
        std::memcpy(bytes->data() + at + name.size() + 4, &window, 16);
        ASSERT_TRUE(writeFileAtomically(folder / "forged.exr", bytes->data(), bytes->size()));
        const auto read = readExr(folder / "forged.exr");
        ASSERT_FALSE(read);
        EXPECT_EQ(read.error().code, ErrorCode::FileInvalid);
        EXPECT_EQ(read.error().message.find("bad_alloc"), std::string::npos) << "refused, not tried";
    }
}

TEST(DecodeImage, DamagedBytesGiveErrorsOrPictures)
{
    const auto png = encodePng(noise(32, 32));
    ASSERT_TRUE(png);
    ASSERT_TRUE(decodeImage(png->data(), png->size()));
    // Cut anywhere in the first part, it cannot be whole.
    for (std::size_t length = 0; length < png->size() / 2; length += 7) {
        const auto image = decodeImage(png->data(), length);
        ASSERT_FALSE(image) << length;
        EXPECT_EQ(image.error().code, ErrorCode::FileInvalid);
        EXPECT_FALSE(image.error().message.empty());
    }
    // Bytes changed anywhere: an error, or a picture of a plausible size; never a crash (run under AddressSanitizer
    // too).
    for (uint32_t n = 0; n < 3000; ++n) {
        auto bytes = *png;
        for (uint32_t i = 0; i <= n % 4; ++i)
            bytes[hashPcg(n * 4 + i) % bytes.size()] = std::byte(hashPcg(n ^ i * 77u));
        const auto image = decodeImage(bytes.data(), bytes.size());
        if (image) {
            EXPECT_EQ(image->texelCount(), std::size_t(image->width()) * std::size_t(image->height()));
        }
    }
}

// PNG allows image data chunks of no bytes (section 11.2.4): the first one here.
TEST(DecodeImage, EmptyDataChunksChangeNothing)
{
    auto png = encodePng(noise(4, 4));
    ASSERT_TRUE(png);
    const auto whole = decodeImage(png->data(), png->size());
    ASSERT_TRUE(whole);
    const std::string type = "IDAT";
    const auto at = std::search(png->begin(), png->end(), type.begin(), type.end(),
                                [](std::byte a, char b) { return a == std::byte(b); });
    ASSERT_NE(at, png->end());
    constexpr unsigned char kEmpty[12] = {0, 0, 0, 0, 'I', 'D', 'A', 'T', 0x35, 0xaf, 0x06, 0x1e};
    const auto bytes = std::as_bytes(std::span(kEmpty));
    png->insert(at - 4, bytes.begin(), bytes.end()); // before the chunk's length
    const auto image = decodeImage(png->data(), png->size());
    ASSERT_TRUE(image) << image.error().message;
    EXPECT_TRUE(std::ranges::equal(image->texels(), whole->texels()));
}

TEST(DecodeImage, ForgedSizeIsRefusedAtOnce)
{
    auto png = encodePng(noise(4, 4));
    ASSERT_TRUE(png);
    // Width and height: big-endian at 16 and 20 of the file. Over any limit, and 8192 x 8192.
    const unsigned char huge[8] = {0x00, 0xff, 0xff, 0xff, 0x00, 0xff, 0xff, 0xff};
    std::memcpy(png->data() + 16, huge, 8);
    EXPECT_FALSE(decodeImage(png->data(), png->size()));
    const unsigned char large[8] = {0x00, 0x00, 0x20, 0x00, 0x00, 0x00, 0x20, 0x00};
    std::memcpy(png->data() + 16, large, 8);
    const auto image = decodeImage(png->data(), png->size());
    ASSERT_FALSE(image);
    EXPECT_NE(image.error().message.find("more texels"), std::string::npos) << image.error().message;
}

TEST(DecodeImage, GarbageIsAnError)
{
    const char text[] = "neither PNG nor JPEG";
    EXPECT_FALSE(decodeImage(reinterpret_cast<const std::byte*>(text), sizeof text));
    EXPECT_FALSE(decodeImage(nullptr, 0));
}

} // namespace
} // namespace halflight::image_test
