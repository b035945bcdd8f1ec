// Lightmaps in each format, masks in the smaller of two: what a reader sees of them, against the floats they came from.

#include "fixtures.h"
#include "scene/pictures/ktx2.h"
#include "scene/pictures/lightmap_curve.h"

#include "halflight/base/encoded_image.h"
#include "halflight/base/rgb9e5.h"

#include <cmath>
#include <gmock/gmock.h>
#include <zstd.h>

namespace halflight::lightmap_formats_test {
namespace {

using namespace test;

/// Light from 0.01 to 100,000 lux, in many colours.
ImageRgb32f brightAndDark(int size)
{
    ImageRgb32f page(size, size);
    for (int y = 0; y < size; ++y) {
        for (int x = 0; x < size; ++x) {
            const float lux = std::exp2(-7.0f + 23.5f * (float(y) + 0.5f) / float(size));
            const float share = float(x) / float(size);
            page(x, y) = lux * vec3(1.0f, 0.2f + 0.8f * share, 1.0f - share);
        }
    }
    return page;
}

float largest(vec3 v)
{
    return std::max({v.x, v.y, v.z});
}

struct Written {
    BakedScene read;
    WrittenBytes bytes;
    Json json;
};

class LightmapFormats : public testing::Test {
protected:
    /// Pages of a bake in lux, written and read in a format.
    void write(LightmapFormat format, Written& result)
    {
        BakedScene baked = pretendToBake(engineScene(), false);
        baked.lightmapUnitLux = 2.0f;
        baked.lightmaps.clear();
        for (const ImageRgb32f& page : pages) {
            Image<uint32_t> packed(page.width(), page.height());
            for (std::size_t i = 0; i < page.texelCount(); ++i)
                packed.texels()[i] = packRgb9e5(page.texels()[i] / 2.0f);
            baked.lightmaps.push_back(std::move(packed));
        }
        WriteOptions options;
        options.lightmapFormat = format;
        options.irradiance = pages;
        options.written = &result.bytes;
        const std::filesystem::path file = folder / (std::string(nameOf(format)) + ".glb");
        const Status done = writeBakedScene(file, baked, options);
        ASSERT_TRUE(done) << done.error().text();
        auto read = readBakedScene(file);
        ASSERT_TRUE(read) << read.error().text();
        result.read = std::move(*read);
        result.json = jsonOfGlb(file);
    }

    const TemporaryFolder folder;
    const std::vector<ImageRgb32f> pages = {brightAndDark(64), brightAndDark(64)};
};

/// Largest error of a channel over the texel's brightest, as a reader sees it.
double largestError(const ImageRgb32f& truth, const Image<uint32_t>& read, float unit)
{
    double most = 0.0;
    const ImageRgb32f seen = decodeRgb9e5(read, unit);
    float brightestOfPage = 0.0f;
    for (const vec3 texel : truth.texels()) brightestOfPage = std::max(brightestOfPage, largest(texel));
    for (std::size_t i = 0; i < truth.texelCount(); ++i) {
        const vec3 was = truth.texels()[i];
        const float scale = std::max(largest(was), brightestOfPage / 4096.0f);
        most = std::max(most, double(largest(glm::abs(seen.texels()[i] - was)) / scale));
    }
    return most;
}

TEST_F(LightmapFormats, Rgb9e5ErrsByHalfAStepOfItsMantissa)
{
    Written written;
    ASSERT_NO_FATAL_FAILURE(write(LightmapFormat::Rgb9e5, written));
    ASSERT_EQ(written.bytes.lightmapPages.size(), 2u);
    for (std::size_t p = 0; p < 2; ++p) {
        const double most = largestError(pages[p], written.read.lightmaps.at(p), 2.0f);
        EXPECT_NEAR(written.bytes.lightmapPages[p].mostError, most, 1.0e-6);
        EXPECT_LE(most, std::exp2(-9.0) * 1.001); // half of a mantissa's step, 256 at least
        EXPECT_GT(most, std::exp2(-10.0));
        EXPECT_LT(written.bytes.lightmapPages[p].meanError, most);
    }
    EXPECT_EQ(written.bytes.lightmaps, written.bytes.lightmapPages[0].bytes + written.bytes.lightmapPages[1].bytes);
}

TEST_F(LightmapFormats, HalfFloatsAreFourTimesAsExact)
{
    Written written;
    ASSERT_NO_FATAL_FAILURE(write(LightmapFormat::Half, written));
    const Json& root = written.json["extensions"]["HALFLIGHT_mixed_lighting"];
    EXPECT_FALSE(root.contains("lightmapEncoding"));
    for (std::size_t p = 0; p < 2; ++p) {
        EXPECT_LE(written.bytes.lightmapPages.at(p).mostError, std::exp2(-11.0) * 1.001);
        EXPECT_GT(written.bytes.lightmapPages[p].mostError, std::exp2(-12.0));
        EXPECT_LE(largestError(pages[p], written.read.lightmaps.at(p), 2.0f), std::exp2(-9.0) + std::exp2(-11.0))
            << "the reader keeps RGB9E5";
    }
}

TEST_F(LightmapFormats, WebpHasTheErrorThatTheReportSays)
{
    if (!decodesWebp()) GTEST_SKIP() << "this build has no libwebp";
    Written written;
    ASSERT_NO_FATAL_FAILURE(write(LightmapFormat::Webp, written));
    const Json& root = written.json["extensions"]["HALFLIGHT_mixed_lighting"];
    EXPECT_TRUE(root["lightmapEncoding"].contains("scale"));
    EXPECT_EQ(root["lightmaps"].size(), 2u);
    for (const Json& reference : root["lightmaps"]) {
        const Json& texture = written.json["textures"][reference["index"].get<std::size_t>()];
        EXPECT_TRUE(texture["extensions"].contains("EXT_texture_webp"));
        EXPECT_FALSE(texture["extensions"].contains("HALFLIGHT_texture_ktx2"));
    }
    for (std::size_t p = 0; p < 2; ++p) {
        const double most = largestError(pages[p], written.read.lightmaps.at(p), 2.0f);
        EXPECT_NEAR(written.bytes.lightmapPages.at(p).mostError, most, 1.0e-6);
        EXPECT_GT(written.bytes.lightmapPages[p].meanError, std::exp2(-9.0)) << "256 values for 23 stops";
        EXPECT_LT(written.bytes.lightmapPages[p].meanError, 0.05);
    }
}

TEST(Ktx2Half, FieldsAreWhereTheSpecificationPutsThem)
{
    const auto file = encodeKtx2(halfTexels(brightAndDark(16)));
    ASSERT_TRUE(file);
    const auto u32 = [&](std::size_t offset) {
        uint32_t value = 0;
        std::memcpy(&value, file->data() + offset, 4);
        return value;
    };
    EXPECT_EQ(u32(12), 97u); // VK_FORMAT_R16G16B16A16_SFLOAT
    EXPECT_EQ(u32(16), 2u);  // typeSize
    EXPECT_EQ(u32(96), 16u * 16u * 8u);
    const uint32_t dfd = u32(48);
    EXPECT_EQ(u32(dfd), 4u + 24u + 4u * 16u);
    EXPECT_EQ(u32(dfd + 20), 8u); // bytesPlane0
    for (uint32_t s = 0; s < 4; ++s) {
        const std::size_t sample = dfd + 28 + 16 * s;
        EXPECT_EQ(u32(sample) & 0xffff, 16 * s);
        EXPECT_EQ(u32(sample) >> 16 & 0xff, 15u);
        EXPECT_EQ(u32(sample) >> 24, (s == 3 ? 15u : s) | 0xC0u); // signed float
        EXPECT_EQ(u32(sample + 8), 0xBF800000u);
        EXPECT_EQ(u32(sample + 12), 0x3F800000u);
    }
    const auto read = decodeKtx2(*file);
    ASSERT_TRUE(read) << read.error().text();
    EXPECT_EQ(read->size(), ivec2(16, 16));
    for (std::size_t n = 0; n < file->size(); n += 5) EXPECT_FALSE(decodeKtx2(std::span(*file).first(n))) << n;
}

// The nearest of all representable values: a mantissa of 0…511 times a power of two that all channels share.
TEST(Rgb9e5, PacksTheWholeRange)
{
    for (const float value : {0.0f, 1.0e-6f, 0.1f, 1.0f, 255.9f, 511.6f, 32767.0f, 33000.0f, 65408.0f}) {
        const vec3 color(value, value / 3.0f, value / 200.0f);
        const Image<uint32_t> packed(1, 1, packRgb9e5(color));
        const vec3 read = decodeRgb9e5(packed)(0, 0);
        float step = std::max(std::exp2(std::floor(std::log2(std::max(value, 1.0e-9f))) - 8.0f), std::exp2(-24.0f));
        if (value / step >= 511.5f) step *= 2.0f; // there is no mantissa of 512
        for (int c = 0; c < 3; ++c) EXPECT_LE(std::abs(read[c] - color[c]), 0.501f * step + 1.0e-12f) << value;
    }
    const auto read = [](vec3 color) { return decodeRgb9e5(Image<uint32_t>(1, 1, packRgb9e5(color)))(0, 0); };
    EXPECT_EQ(read(vec3(1.0e9f, -1.0f, std::nanf(""))), vec3(kMaxRgb9e5, 0.0f, 0.0f));
    const LightmapCurve curve{65408.0f, 2.0f};
    EXPECT_EQ(decodeRgb9e5(decodeByCurve(ImageRgba8(1, 1, u8vec4(255)), curve))(0, 0), vec3(65408.0f));
}

TEST(Masks, AreWrittenInTheSmallerFormatEach)
{
    if (!decodesWebp()) GTEST_SKIP() << "this build has no libwebp";
    const TemporaryFolder folder;
    BakedScene baked = pretendToBake(engineScene(), false);
    ImageRgba8& smooth = baked.shadowmasks.at(0);
    smooth = ImageRgba8(64, 64);
    for (int y = 0; y < 64; ++y) {
        for (int x = 0; x < 64; ++x) smooth(x, y) = u8vec4(4 * x, 4 * y, 2 * (x + y), 255 - 2 * x);
    }
    baked.shadowmasks.at(1) = ImageRgba8(64, 64, u8vec4(255, 0, 7, 0)); // colour where alpha is 0
    WrittenBytes bytes;
    WriteOptions options;
    options.written = &bytes;
    ASSERT_TRUE(writeBakedScene(folder / "baked.glb", baked, options));
    const auto read = readBakedScene(folder / "baked.glb");
    ASSERT_TRUE(read) << read.error().text();
    uint64_t least = 0;
    for (std::size_t p = 0; p < 2; ++p) {
        EXPECT_EQ(read->shadowmasks.at(p).texels(), baked.shadowmasks[p].texels());
        least += std::min(encodePng(baked.shadowmasks[p])->size(), encodeWebpLossless(baked.shadowmasks[p])->size());
    }
    EXPECT_EQ(bytes.shadowmasks, least);
}

} // namespace
} // namespace halflight::lightmap_formats_test
