// What a small file may make the reader take: sums over all accessors and images have limits, shared data is kept once.

#include "fixtures.h"
#include "halflight/base/image.h"

#include <gmock/gmock.h>
#include <unistd.h>

namespace halflight::test::limits_test {

namespace {

using testing::HasSubstr;

// A PNG of one colour, as small as libpng makes it.
std::vector<uint8_t> png(int side)
{
    const auto encoded = encodePng(ImageRgba8(side, side, u8vec4(1, 2, 3, 255)));
    const auto* first = reinterpret_cast<const uint8_t*>(encoded->data());
    return {first, first + encoded->size()};
}

// `count` materials on one triangle each, every one with a texture and an image of its own.
GltfBuilder texturedTriangles(int count, const std::function<Json(GltfBuilder&)>& image)
{
    GltfBuilder file;
    file.triangle();
    Json& primitives = file.json["meshes"][0]["primitives"];
    const Json first = primitives[0];
    primitives = Json::array();
    for (int i = 0; i < count; ++i) {
        file.json["images"].push_back(image(file));
        file.json["textures"].push_back({{"source", i}});
        file.json["materials"].push_back({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", i}}}}}});
        primitives.push_back(first);
        primitives.back()["material"] = i;
    }
    return file;
}

// 200 primitives without indices read one accessor that has no data: 2.5 GB of positions alone.
TEST(Limits, ElementsWithoutDataAreCountedOverAllPrimitives)
{
    const TemporaryFolder folder;
    const auto errorOf = [&](int primitiveCount, int elements) {
        GltfBuilder file;
        file.triangle();
        file.json["accessors"] = {{{"componentType", 5126}, {"count", elements}, {"type", "VEC3"}}};
        Json& primitives = file.json["meshes"][0]["primitives"];
        const Json first = primitives[0];
        for (int i = 1; i < primitiveCount; ++i) primitives.push_back(first);
        const auto scene = readScene(file.write(folder));
        return scene ? std::string("loaded") : scene.error().text();
    };
    EXPECT_EQ(errorOf(10, 3000), "loaded");
    EXPECT_THAT(errorOf(200, 1 << 20), HasSubstr("/accessors: meshes, nodes and animations read 209715200 elements"));
}

// The same for instances, which are objects of a few hundred bytes each.
TEST(Limits, InstancesAreCountedToo)
{
    const TemporaryFolder folder;
    GltfBuilder file;
    file.triangle();
    const int translations = file.add({{"componentType", 5126}, {"count", 1 << 20}, {"type", "VEC3"}});
    file.json["nodes"] = Json::array();
    file.json["scenes"][0]["nodes"] = Json::array();
    for (int i = 0; i < 50; ++i) {
        Json node = {{"mesh", 0}};
        node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] = translations;
        file.json["nodes"].push_back(node);
        file.json["scenes"][0]["nodes"].push_back(i);
    }
    const auto scene = readScene(file.write(folder));
    ASSERT_FALSE(scene);
    EXPECT_THAT(scene.error().text(), HasSubstr("elements in all, more than the limit"));
}

TEST(Limits, AnImageNamedManyTimesIsDecodedOnce)
{
    const TemporaryFolder folder;
    const std::vector<uint8_t> bytes = png(1024);
    int view = -1;
    GltfBuilder file = texturedTriangles(100, [&](GltfBuilder& f) {
        if (view < 0) view = f.view(bytes);
        return Json{{"bufferView", view}, {"mimeType", "image/png"}};
    });
    file.json["samplers"] = {{{"wrapS", 33071}}};
    file.json["textures"][7]["sampler"] = 0; // shown in another way: a texture of its own
    const auto scene = readScene(file.write(folder));
    ASSERT_TRUE(scene) << scene.error().text();
    ASSERT_EQ(scene->textures.size(), 2u);
    EXPECT_EQ(scene->materials[3].baseColorTexture.texture, scene->materials[99].baseColorTexture.texture);
    EXPECT_NE(scene->materials[3].baseColorTexture.texture, scene->materials[7].baseColorTexture.texture);
    EXPECT_EQ(scene->textures[1].wrapU, Texture::Wrap::ClampToEdge);
    EXPECT_EQ(scene->textures[1].pixels(1023, 1023), u8vec4(1, 2, 3, 255));
}

// Images of their own, each within the limit for one: 4096 x 4096 texels, 64 MiB decoded, from 2 kB of PNG.
TEST(Limits, TexelsAreCountedOverAllImages)
{
    const TemporaryFolder folder;
    std::ifstream stream(std::filesystem::path(HALFLIGHT_SOURCE_DIR) / "assets/tests/compressed/black_4096.png",
                         std::ios::binary);
    const std::vector<uint8_t> bytes((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
    ASSERT_FALSE(bytes.empty());
    const auto read = [&](int count) {
        GltfBuilder file = texturedTriangles(count, [&](GltfBuilder& f) {
            return Json{{"bufferView", f.view(bytes)}, {"mimeType", "image/png"}};
        });
        const auto scene = readScene(file.write(folder));
        return scene ? std::string("loaded") : scene.error().text();
    };
    EXPECT_EQ(read(1), "loaded");
    EXPECT_THAT(read(6), HasSubstr("/images: decoded, they hold 100663296 texels in all, more than the limit"));
}

// A sparse file that claims 5 GiB: refused by its size, not read.
TEST(Limits, FilesAreMeasuredBeforeTheyAreRead)
{
    const TemporaryFolder folder;
    writeText(folder / "huge.glb", "glTF");
    std::filesystem::resize_file(folder / "huge.glb", uintmax_t(5) << 30);
    const auto scene = readScene(folder / "huge.glb");
    ASSERT_FALSE(scene);
    EXPECT_THAT(scene.error().message, HasSubstr("4 GiB"));
}

// Buffers that name one huge file again and again.
TEST(Limits, BuffersAreCountedTogether)
{
    const TemporaryFolder folder;
    GltfBuilder file;
    file.triangle();
    file.write(folder);
    writeText(folder / "huge.bin", "x");
    std::filesystem::resize_file(folder / "huge.bin", uintmax_t(1) << 30);
    for (int i = 0; i < 5; ++i) file.json["buffers"].push_back({{"byteLength", 1 << 30}, {"uri", "huge.bin"}});
    writeText(folder / "scene.gltf", file.json.dump());
    const auto scene = readScene(folder / "scene.gltf");
    ASSERT_FALSE(scene);
    EXPECT_THAT(scene.error().text(), HasSubstr("buffers of 4 GiB and more in all"));
}

} // namespace

} // namespace halflight::test::limits_test
