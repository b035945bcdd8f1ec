// URIs of buffers and images: RFC 3986 names, RFC 2397 data: URIs, and files that nobody should wait for.

#include "fixtures.h"
#include "halflight/base/image.h"
#include "scene/document/uri.h"

#include <gmock/gmock.h>
#include <sys/stat.h>

namespace halflight::test::uri_test {

namespace {

using testing::HasSubstr;

std::string base64(std::string_view bytes)
{
    constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        uint32_t bits = 0;
        for (std::size_t k = 0; k < 3; ++k) bits = bits << 8 | (i + k < bytes.size() ? uint8_t(bytes[i + k]) : 0u);
        for (std::size_t k = 0; k < 4; ++k) text += i + k <= bytes.size() ? kDigits[bits >> (18 - 6 * k) & 63] : '=';
    }
    return text;
}

// A triangle with a texture, its buffer and its image behind the URIs that a test gives.
class Uris : public testing::Test {
protected:
    Uris()
    {
        const float positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
        buffer_.assign(reinterpret_cast<const char*>(positions), sizeof positions);
        const auto png = encodePng(ImageRgba8(2, 2, u8vec4(10, 20, 30, 255)));
        image_.assign(reinterpret_cast<const char*>(png->data()), png->size());
        writeText(folder_ / "good.bin", buffer_);
        writeText(folder_ / "good.png", image_);
    }

    std::string read(const std::string& bufferUri, const std::string& imageUri)
    {
        const Json json = {
            {"asset", {{"version", "2.0"}}},
            {"scene", 0},
            {"scenes", {{{"nodes", {0}}}}},
            {"nodes", {{{"mesh", 0}}}},
            {"meshes", {{{"primitives", {{{"attributes", {{"POSITION", 0}}}, {"material", 0}}}}}}},
            {"materials", {{{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}}}},
            {"textures", {{{"source", 0}}}},
            {"images", {{{"uri", imageUri}}}},
            {"accessors", {{{"bufferView", 0}, {"componentType", 5126}, {"count", 3}, {"type", "VEC3"}}}},
            {"bufferViews", {{{"buffer", 0}, {"byteLength", 36}}}},
            {"buffers", {{{"byteLength", 36}, {"uri", bufferUri}}}}};
        writeText(folder_ / "scene.gltf", json.dump());
        const auto scene = readScene(folder_ / "scene.gltf");
        if (!scene) return scene.error().text();
        EXPECT_EQ(scene->meshes.at(0).parts.at(0).positions.at(1), vec3(1, 0, 0));
        EXPECT_EQ(scene->textures.at(0).pixels(1, 1), u8vec4(10, 20, 30, 255));
        return "loaded";
    }
    // The same name for buffer and image, which lie at `file` (one content after the other).
    void expectBoth(const std::string& uri, const std::string& file)
    {
        writeText(folder_ / file, buffer_);
        EXPECT_EQ(read(uri, "good.png"), "loaded") << uri;
        writeText(folder_ / file, image_);
        EXPECT_EQ(read("good.bin", uri), "loaded") << uri;
        std::filesystem::remove(folder_ / file);
    }

    TemporaryFolder folder_;
    std::string buffer_;
    std::string image_;
};

TEST_F(Uris, PlusIsAPlusAndNamesAreTriedAsTheyStand)
{
    expectBoth("a+b.dat", "a+b.dat");
    expectBoth("a%2Bb.dat", "a+b.dat");
    expectBoth("example 10%.dat", "example 10%.dat");
    expectBoth("example%2010%25.dat", "example 10%.dat");
    expectBoth("a%20b.dat", "a b.dat");
    expectBoth("a%20b.dat", "a%20b.dat");
    expectBoth("h%c3%A4user.dat", "h\xc3\xa4user.dat");
    expectBoth("100%2.dat", "100%2.dat");
    std::filesystem::create_directory(folder_ / "sub");
    expectBoth("./sub/../sub//x.dat", "sub/x.dat");
    // Where both are there, decoding wins.
    writeText(folder_ / "x y.bin", buffer_);
    writeText(folder_ / "x%20y.bin", "not this");
    EXPECT_EQ(read("x%20y.bin", "good.png"), "loaded");
}

TEST_F(Uris, DataWithAndWithoutMediaType)
{
    for (const char* header :
         {"data:application/octet-stream;base64,", "data:;base64,", "data:base64;base64,", "DATA:;BASE64,",
          "Data:application/gltf-buffer;charset=utf-8;base64,", "data:image/png;name=a;base64,"}) {
        EXPECT_EQ(read(header + base64(buffer_), header + base64(image_)), "loaded") << header;
    }
    std::string percent;
    for (const char c : buffer_)
        percent += "%" + std::string(1, "0123456789abcdef"[uint8_t(c) >> 4]) + "0123456789ABCDEF"[c & 15];
    EXPECT_EQ(read("data:," + percent, "good.png"), "loaded");
    EXPECT_EQ(read("data:text/plain;charset=x," + percent, "good.png"), "loaded");
    std::string loose = base64(buffer_);
    loose.insert(20, "\r\n ");
    while (loose.back() == '=') loose.pop_back();
    EXPECT_EQ(read("data:;base64," + loose, "good.png"), "loaded");
    EXPECT_THAT(read("data:;base64,AA*A", "good.png"), HasSubstr("/buffers/0: the data: URI is not valid base64"));
    EXPECT_THAT(read("data:;base64", "good.png"), HasSubstr("/buffers/0: the data: URI has no comma"));
    EXPECT_THAT(read("data:;base64,AAAA", "good.png"), HasSubstr("/buffers/0: byteLength is 36, but it holds 3 bytes"));
    EXPECT_THAT(read("good.bin", "data:image/png;base64,AAAA"), HasSubstr("/images/0: "));
}

TEST_F(Uris, WhatIsNoFileIsOneSentence)
{
    ASSERT_EQ(::mkfifo((folder_ / "pipe").c_str(), 0600), 0);
    std::filesystem::create_directory(folder_ / "sub");
    std::filesystem::create_symlink("/dev/zero", folder_ / "zeros");
    for (const auto& [uri, reason] :
         {std::pair("", "uri is empty"), std::pair(".", "is a folder"), std::pair("..", "is a folder"),
          std::pair("sub/", "is a folder"), std::pair("%00", "zero byte"), std::pair("good.bin%00", "zero byte"),
          std::pair("pipe", "a pipe"), std::pair("zeros", "is a device"), std::pair("gone", "no such file"),
          std::pair("https://x.org/a", "scheme https"), std::pair("file:///tmp/a", "scheme file")}) {
        EXPECT_THAT(read(uri, "good.png"), testing::AllOf(HasSubstr("/buffers/0: "), HasSubstr(reason))) << uri;
        EXPECT_THAT(read("good.bin", uri), testing::AllOf(HasSubstr("/images/0: "), HasSubstr(reason))) << uri;
    }
}

// glTF 2.0, section 3.6.1.1: the data must be byteLength long at least.
TEST_F(Uris, BuffersMayBeLongerThanTheySay)
{
    writeText(folder_ / "longer.bin", buffer_ + "and more");
    EXPECT_EQ(read("longer.bin", "good.png"), "loaded");
    EXPECT_EQ(read("data:;base64," + base64(buffer_ + "and more"), "good.png"), "loaded");
    writeText(folder_ / "shorter.bin", buffer_.substr(1));
    EXPECT_THAT(read("shorter.bin", "good.png"), HasSubstr("/buffers/0: byteLength is 36, but it holds 35 bytes"));
}

} // namespace

} // namespace halflight::test::uri_test
