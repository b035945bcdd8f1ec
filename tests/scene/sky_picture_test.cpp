// Pictures of the sky: read from files, named in settings, kept in baked files (spec S5, S30).

#include "encode_rgbe.h"
#include "fixtures.h"
#include "halflight/base/file.h"
#include "halflight/base/rgb9e5.h"
#include "halflight/scene/optimize.h"
#include "halflight/scene/sky_picture.h"
#include "scene/pictures/rgbe.h"
#include "scene/settings/settings.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

namespace halflight::sky_picture_test {
namespace {

using namespace test;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

ImageRgb32f noise(int width, int height)
{
    ImageRgb32f picture(width, height);
    for (std::size_t i = 0; i < picture.texelCount(); ++i)
        picture.data()[i] = vec3(float(i % 7), float(i % 11) * 0.5f, float(i % 3) + 0.25f);
    return picture;
}

/// The integral over the sphere of a picture of constant texels.
glm::dvec3 lightOf(const ImageRgb32f& picture)
{
    glm::dvec3 sum(0.0);
    for (int y = 0; y < picture.height(); ++y) {
        const double h = picture.height();
        const double band = std::cos(y / h * double(kPi)) - std::cos((y + 1) / h * double(kPi));
        for (int x = 0; x < picture.width(); ++x)
            sum += glm::dvec3(picture(x, y)) * (band * 2.0 * double(kPi) / picture.width());
    }
    return sum;
}

std::filesystem::path writeHdr(const std::filesystem::path& path, const ImageRgb32f& picture)
{
    Image<uint32_t> texels(picture.width(), picture.height());
    for (std::size_t i = 0; i < picture.texelCount(); ++i) texels.data()[i] = packRgb9e5(picture.data()[i]);
    const std::vector<std::byte> bytes = encodeRgbe(texels);
    EXPECT_TRUE(writeFileAtomically(path, bytes.data(), bytes.size()));
    return path;
}

TEST(SkyPicture, ReadsRadianceAndOpenExrByContent)
{
    const TemporaryFolder folder;
    const ImageRgb32f picture = noise(16, 8);
    ASSERT_TRUE(writeExr(folder / "a.exr", picture));
    const auto exr = readSkyPicture(folder / "a.exr");
    ASSERT_TRUE(exr) << exr.error().text();
    EXPECT_EQ(exr->texels(), picture.texels());
    const auto hdr = readSkyPicture(writeHdr(folder / "a.picture", picture));
    ASSERT_TRUE(hdr) << hdr.error().text();
    ASSERT_EQ(hdr->size(), ivec2(16, 8));
    for (std::size_t i = 0; i < picture.texelCount(); ++i)
        EXPECT_LT(glm::distance(hdr->data()[i], picture.data()[i]), 0.03f * glm::length(picture.data()[i]) + 1e-3f);
}

// Texel after texel, where mantissas of 1 repeat the one before.
TEST(SkyPicture, ReadsOlderRadiancePictures)
{
    const TemporaryFolder folder;
    const std::string head = "#?RGBE\n# a comment\nEXPOSURE=1\n\n-Y 2 +X 4\n";
    const std::string first("\x80\x40\x20\x81", 4); // 1, 1/2, 1/4
    const std::string other("\x00\x80\xff\x88", 4); // 0, 128, 255
    writeText(folder / "old.hdr", head + first + std::string("\1\1\1\3", 4) + other + other + first + first);
    const auto read = readSkyPicture(folder / "old.hdr");
    ASSERT_TRUE(read) << read.error().text();
    ASSERT_EQ(read->size(), ivec2(4, 2));
    for (int x = 0; x < 4; ++x) EXPECT_EQ((*read)(x, 0), vec3(1.0f, 0.5f, 0.25f));
    EXPECT_EQ((*read)(1, 1), vec3(0.0f, 128.0f, 255.0f));
    EXPECT_EQ((*read)(2, 1), vec3(1.0f, 0.5f, 0.25f));
    writeText(folder / "long.hdr", head + first + std::string("\1\1\1\4", 4) + other + other + first + first);
    EXPECT_FALSE(readSkyPicture(folder / "long.hdr"));
    writeText(folder / "upside.hdr", "#?RADIANCE\n\n+Y 2 +X 4\n" + first);
    EXPECT_FALSE(readSkyPicture(folder / "upside.hdr"));
}

TEST(SkyPicture, UnusableFilesAreErrorsThatNameThem)
{
    const TemporaryFolder folder;
    const auto errorOf = [&](const char* name) {
        const auto read = readSkyPicture(folder / name);
        EXPECT_FALSE(read);
        return read ? "" : read.error().text();
    };
    EXPECT_THAT(errorOf("missing.hdr"), HasSubstr("missing.hdr"));
    writeText(folder / "text.hdr", "not a picture");
    EXPECT_THAT(errorOf("text.hdr"), HasSubstr("neither a Radiance picture (.hdr) nor OpenEXR"));
    writeText(folder / "empty.hdr", "");
    EXPECT_THAT(errorOf("empty.hdr"), HasSubstr("neither a Radiance picture"));
    writeText(folder / "forged.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 16384 +X 32768\nxxxx");
    EXPECT_THAT(errorOf("forged.hdr"), HasSubstr("texels"));
    writeText(folder / "short.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8 +X 16\nxxxx");
    EXPECT_THAT(errorOf("short.hdr"), HasSubstr("ends before its last texel"));
    ASSERT_TRUE(writeExr(folder / "good.exr", noise(16, 8)));
    std::vector<std::byte> truncated = *readFile(folder / "good.exr");
    truncated.resize(truncated.size() / 2);
    ASSERT_TRUE(writeFileAtomically(folder / "half.exr", truncated.data(), truncated.size()));
    EXPECT_THAT(errorOf("half.exr"), HasSubstr("half.exr"));
}

// Case sky-values: filters overshoot, half floats overflow. All other texels stay as they are.
TEST(SkyPicture, OddValuesAreClampedAndCounted)
{
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    struct Odd {
        float value;
        float brightest; // of another texel
        float right;
        const char* warning;
    };
    for (const Odd& odd : {Odd{-0.001f, 1.0f, 0.0f, "2 texels have a negative value"},
                           Odd{-kInfinity, 1.0f, 0.0f, "2 texels have a negative value"},
                           Odd{kNan, 1.0f, 0.0f, "2 texels have a value that is not a number"},
                           Odd{kInfinity, 1.0f, 65504.0f, "2 texels have an infinite value"},
                           Odd{kInfinity, 3.0e6f, 3.0e6f, "2 texels have an infinite value"}}) {
        const TemporaryFolder folder;
        ImageRgb32f picture = noise(16, 8);
        picture(0, 0) = vec3(odd.brightest);
        ImageRgb32f right = picture;
        for (const ivec2 at : {ivec2(5, 3), ivec2(9, 7)}) {
            picture(at.x, at.y).y = odd.value;
            right(at.x, at.y).y = odd.right;
        }
        ASSERT_TRUE(writeExr(folder / "odd.exr", picture));
        std::vector<std::string> warnings;
        const auto read = readSkyPicture(folder / "odd.exr", &warnings);
        ASSERT_TRUE(read) << read.error().text();
        EXPECT_EQ(read->texels(), right.texels()) << odd.value;
        EXPECT_THAT(warnings, ElementsAre(AllOf(HasSubstr("odd.exr"), HasSubstr(odd.warning)))) << odd.value;
    }
}

// Radiance 5.3, "Radiance File Formats": values are divided by all EXPOSURE and COLORCORR lines multiplied together.
TEST(SkyPicture, ExposureOfTheHeaderIsTakenOut)
{
    const std::string texel("\x80\x40\x20\x81", 4); // 1, 1/2, 1/4
    const auto read = [&](const std::string& lines, std::vector<std::string>& warnings) {
        const TemporaryFolder folder;
        writeText(folder / "e.hdr", "#?RADIANCE\n" + lines + "\n-Y 1 +X 1\n" + texel);
        const auto picture = readSkyPicture(folder / "e.hdr", &warnings);
        EXPECT_TRUE(picture) << lines;
        return picture ? (*picture)(0, 0) : vec3(-1.0f);
    };
    std::vector<std::string> warnings;
    EXPECT_EQ(read("EXPOSURE=2\n", warnings), vec3(0.5f, 0.25f, 0.125f));
    EXPECT_EQ(read("EXPOSURE= 0.25\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=2.0\n", warnings), vec3(2.0f, 1.0f, 0.5f));
    EXPECT_EQ(read("COLORCORR=2 1 0.5\nEXPOSURE=0.5\n", warnings), vec3(1.0f, 1.0f, 1.0f));
    EXPECT_EQ(read("COLORCORR= 2 2 2\nCOLORCORR= 2 1 1\n", warnings), vec3(0.25f, 0.25f, 0.125f));
    EXPECT_EQ(read("VIEW= -vta EXPOSURE=4\nPRIMARIES= .64 .33 .29 .6 .15 .06 .3333 .3333\n", warnings),
              vec3(1.0f, 0.5f, 0.25f));
    EXPECT_THAT(warnings, IsEmpty());
    for (const char* odd : {"EXPOSURE=0\n", "EXPOSURE=-2\n", "EXPOSURE=nan\n", "EXPOSURE=\n", "COLORCORR=1 2\n",
                            "EXPOSURE=1e999\n", "PRIMARIES=.7 .29 .17 .8 .13 .05 .33 .33\n"}) {
        warnings.clear();
        EXPECT_EQ(read(odd, warnings), vec3(1.0f, 0.5f, 0.25f)) << odd;
        EXPECT_THAT(warnings, ElementsAre(HasSubstr("e.hdr"))) << odd;
    }
    // Beyond floats: clamped like any infinite value.
    warnings.clear();
    EXPECT_EQ(read("EXPOSURE=1e-40\n", warnings), vec3(65504.0f));
    EXPECT_THAT(warnings, ElementsAre(HasSubstr("1 texel has an infinite value")));
}

TEST(SkyPicture, ReductionKeepsTheLight)
{
    const ImageRgb32f picture = noise(96, 48);
    const glm::dvec3 light = lightOf(picture);
    for (const ivec2 size : {ivec2(48, 24), ivec2(31, 17), ivec2(5, 1), ivec2(1, 1)}) {
        const glm::dvec3 reduced = lightOf(reducedSkyPicture(picture, size));
        EXPECT_LT(glm::distance(reduced, light), 1e-5 * glm::length(light)) << size.x;
    }
    EXPECT_EQ(reducedSkyPicture(picture, 200).texels(), picture.texels());
}

// The gradient of a gradient's picture is that gradient; a constant's is the constant, of any size.
TEST(SkyPicture, FindsTheNearestGradient)
{
    ImageRgb32f picture(32, 256);
    for (int y = 0; y < picture.height(); ++y) {
        const float up = std::cos((float(y) + 0.5f) / 256.0f * kPi);
        for (int x = 0; x < 32; ++x)
            picture(x, y) = glm::mix(vec3(4, 3, 2), up > 0.0f ? vec3(1, 2, 8) : vec3(0.5f, 0.1f, 0.3f), std::abs(up));
    }
    Sky sky;
    sky.setPicture(std::make_shared<const ImageRgb32f>(std::move(picture)), 0.3f);
    EXPECT_LT(glm::distance(sky.horizon, vec3(4, 3, 2)), 1e-2f);
    EXPECT_LT(glm::distance(sky.zenith, vec3(1, 2, 8)), 1e-2f);
    EXPECT_LT(glm::distance(sky.ground, vec3(0.5f, 0.1f, 0.3f)), 1e-2f);
    sky.setPicture(std::make_shared<const ImageRgb32f>(1, 1, vec3(3.0f)), 0.0f);
    EXPECT_LT(glm::distance(sky.zenith, vec3(3.0f)) + glm::distance(sky.horizon, vec3(3.0f)), 1e-5f);
    sky.setPicture(std::make_shared<const ImageRgb32f>(4, 2), 0.0f);
    EXPECT_TRUE(sky.black());
}

struct PlainFile : testing::Test {
    PlainFile()
    {
        std::filesystem::create_directories(folder / "skies");
        EXPECT_TRUE(writeExr(folder / "skies/a.exr", noise(16, 8)));
        EXPECT_TRUE(writeExr(folder / "b.exr", ImageRgb32f(4, 2, vec3(2.0f))));
        file.triangle();
    }
    Result<Scene> read(const Json& extras, const std::string& settings = "")
    {
        file.json["scenes"][0]["extras"] = extras;
        ReadOptions options;
        if (!settings.empty()) {
            writeText(folder / "skies/settings.toml", settings);
            options.settingsFile = folder / "skies/settings.toml";
        }
        return readScene(file.write(folder), options);
    }
    TemporaryFolder folder;
    GltfBuilder file;
};

TEST_F(PlainFile, SettingsNameThePictureBesideThem)
{
    const auto scene = read(Json::object(), "[sky]\nimage = \"a.exr\"\nrotation = 90\nintensity = 2.5\n");
    ASSERT_TRUE(scene) << scene.error().text();
    ASSERT_TRUE(scene->sky.picture);
    EXPECT_EQ((*scene->sky.picture)(5, 3), 2.5f * noise(16, 8)(5, 3));
    EXPECT_FLOAT_EQ(scene->sky.rotationRadians, 0.5f * kPi);
    EXPECT_FALSE(scene->sky.black());
    EXPECT_THAT(scene->warnings, Not(Contains(HasSubstr("no sky"))));
}

TEST_F(PlainFile, ExtrasNameItToo)
{
    const auto scene = read({{"halflight_sky_image", "skies/a.exr"}, {"halflight_sky_rotation", -45}});
    ASSERT_TRUE(scene) << scene.error().text();
    ASSERT_TRUE(scene->sky.picture);
    EXPECT_EQ(scene->sky.picture->size(), ivec2(16, 8));
    EXPECT_FLOAT_EQ(scene->sky.rotationRadians, -0.25f * kPi);
}

// The settings file's sky takes the place of the extras' sky, whichever of the two is a picture.
TEST_F(PlainFile, TheStrongerSkyWins)
{
    const Json extras = {{"halflight_sky_image", "skies/a.exr"}, {"halflight_sky_rotation", 30}};
    auto scene = read(extras, "[sky]\nimage = \"../b.exr\"\n");
    ASSERT_TRUE(scene) << scene.error().text();
    EXPECT_EQ(scene->sky.picture->size(), ivec2(4, 2));
    EXPECT_EQ(scene->sky.rotationRadians, 0.0f);
    scene = read(extras, "[sky]\nrotation = 60\n");
    ASSERT_TRUE(scene) << scene.error().text();
    EXPECT_EQ(scene->sky.picture->size(), ivec2(16, 8));
    EXPECT_FLOAT_EQ(scene->sky.rotationRadians, kPi / 3.0f);
    scene = read(extras, "[sky]\ncolor = 3\n");
    ASSERT_TRUE(scene) << scene.error().text();
    EXPECT_FALSE(scene->sky.picture);
    EXPECT_EQ(scene->sky.horizon, vec3(3.0f));
    scene = read({{"halflight_sky", 3}}, "[sky]\nimage = \"a.exr\"\n");
    ASSERT_TRUE(scene) << scene.error().text();
    EXPECT_TRUE(scene->sky.picture);
}

TEST_F(PlainFile, WrongSkiesAreErrors)
{
    const auto errorOf = [&](const std::string& settings) {
        const auto scene = read(Json::object(), settings);
        EXPECT_FALSE(scene) << settings;
        return scene ? "" : scene.error().text();
    };
    EXPECT_THAT(errorOf("[sky]\nimage = \"a.exr\"\ncolor = 1\n"), HasSubstr("an image and colours"));
    EXPECT_THAT(errorOf("[sky]\nimage = \"no.exr\"\n"), HasSubstr("no.exr"));
    EXPECT_THAT(errorOf("[sky]\nimage = 3\n"), HasSubstr("image must be the name of a .hdr or .exr file"));
    EXPECT_THAT(errorOf("[sky]\nimage = \"a.exr\"\nintensity = -1\n"), HasSubstr("intensity must be a number >= 0"));
    EXPECT_THAT(errorOf("[sky]\nimage = \"a.exr\"\nrotation = \"left\"\n"), HasSubstr("rotation must be"));
    EXPECT_THAT(errorOf("[sky]\nimage = \"a.exr\"\nintensity = 1e30\n"), HasSubstr("its sky is brighter than"));
    const auto scene = read({{"halflight_sky", 1}, {"halflight_sky_rotation", 4}});
    ASSERT_TRUE(scene);
    EXPECT_THAT(scene->warnings, Contains(HasSubstr("which only an image has")));
}

struct BakedSky : testing::Test {
    BakedSky() : baked(pretendToBake(engineScene(), false))
    {
        for (Texture& texture : baked.scene.textures)
            if (texture.pixels.empty()) texture.pixels = ImageRgba8(2, 2, u8vec4(9));
        ImageRgb32f picture = noise(1024, 512);
        picture(300, 100) = vec3(3.0e8f);
        baked.scene.sky.setPicture(std::make_shared<const ImageRgb32f>(std::move(picture)), 1.25f);
        baked.scene.warnings.clear();
    }
    TemporaryFolder folder;
    std::filesystem::path file = folder / "baked.glb";
    BakedScene baked;
};

TEST_F(BakedSky, FilesKeepThePictureSmall)
{
    WrittenBytes written;
    WriteOptions options;
    options.written = &written;
    ASSERT_TRUE(writeBakedScene(file, baked, options));
    EXPECT_GT(written.sky, 1000u);
    EXPECT_LT(written.sky, 512u * 256u * 4u + 1000u);
    const auto read = readBakedScene(file);
    ASSERT_TRUE(read) << read.error().text();
    EXPECT_THAT(read->scene.warnings, IsEmpty());
    const Sky& sky = read->scene.sky;
    ASSERT_TRUE(sky.picture);
    EXPECT_EQ(sky.picture->size(), ivec2(512, 256));
    EXPECT_FLOAT_EQ(sky.rotationRadians, 1.25f);
    EXPECT_EQ(sky.zenith, baked.scene.sky.zenith);
    const glm::dvec3 light = lightOf(*baked.scene.sky.picture);
    EXPECT_LT(glm::distance(lightOf(*sky.picture), light), 0.004 * glm::length(light));
    // Written again it is the same to the bit: the earlier picture gives its place to the new one.
    const BakedScene& again = *read;
    ASSERT_TRUE(writeBakedScene(folder / "again.glb", again));
    const auto reread = readBakedScene(folder / "again.glb");
    ASSERT_TRUE(reread) << reread.error().text();
    EXPECT_EQ(reread->scene.sky.picture->texels(), sky.picture->texels());
    EXPECT_EQ(jsonOfGlb(folder / "again.glb")["textures"].size(), jsonOfGlb(file)["textures"].size());
}

TEST_F(BakedSky, OptimizedFilesKeepIt)
{
    ASSERT_TRUE(writeBakedScene(file, baked));
    OptimizeReport report;
    const Status status = optimizeFile(file, folder / "small.glb", {}, report);
    ASSERT_TRUE(status) << status.error().text();
    const auto before = readBakedScene(file);
    const auto after = readBakedScene(folder / "small.glb");
    ASSERT_TRUE(after) << after.error().text();
    EXPECT_THAT(after->scene.warnings, IsEmpty());
    ASSERT_TRUE(after->scene.sky.picture);
    EXPECT_EQ(after->scene.sky.picture->texels(), before->scene.sky.picture->texels());
}

TEST_F(BakedSky, AChangedSkyIsNoticed)
{
    ASSERT_TRUE(writeBakedScene(file, baked));
    const auto warningsAfter = [&](const auto& change) {
        std::vector<char> binary;
        Json json = jsonOfGlb(file, &binary);
        change(json["extensions"]["HALFLIGHT_mixed_lighting"]["sky"]);
        json["buffers"][0]["uri"] = "binary.bin";
        writeText(folder / "binary.bin", std::string(binary.begin(), binary.end()));
        writeText(folder / "changed.gltf", json.dump());
        const auto read = readBakedScene(folder / "changed.gltf");
        return read ? read->scene.warnings : std::vector{"unreadable: " + read.error().text()};
    };
    EXPECT_THAT(warningsAfter([](Json&) {}), IsEmpty());
    for (const char* key : {"rotation", "unitNits"}) {
        const auto warnings = warningsAfter([&](Json& sky) { sky["picture"][key] = 2.0; });
        ASSERT_EQ(warnings.size(), 1u) << key;
        EXPECT_THAT(warnings[0], HasSubstr("the sky changed since its bake"));
    }
    EXPECT_EQ(warningsAfter([](Json& sky) { sky.erase("picture"); }).size(), 1u);
    EXPECT_THAT(warningsAfter([](Json& sky) { sky["picture"]["index"] = 999; })[0], HasSubstr("unreadable"));
    EXPECT_THAT(warningsAfter([](Json& sky) { sky["picture"]["unitNits"] = 0; })[0], HasSubstr("unitNits"));
    EXPECT_THAT(warningsAfter([](Json& sky) { sky["picture"]["unitNits"] = "a"; })[0], HasSubstr("unreadable"));
    EXPECT_THAT(warningsAfter([](Json& sky) { sky.erase("ground"); })[0], HasSubstr("sky: ground is missing"));
    // So is one of a settings file: the picture of another day on lightmaps of this one.
    ASSERT_TRUE(writeExr(folder / "b.exr", noise(8, 4)));
    writeText(folder / "settings.toml", "[sky]\nimage = \"b.exr\"\n");
    const auto read = readBakedScene(file, {folder / "settings.toml"});
    ASSERT_TRUE(read) << read.error().text();
    EXPECT_EQ(read->scene.sky.picture->size(), ivec2(8, 4));
    EXPECT_THAT(read->scene.warnings, Contains(HasSubstr("the sky changed since its bake")));
}

} // namespace
} // namespace halflight::sky_picture_test
