// Texture coordinates that materials read are the same after a bake, whichever set carries the lightmap's.

#include "fixtures.h"

namespace halflight::texture_sets_test {
namespace {

using namespace test;

/// Two triangles (mesh 0: a part each) whose materials read what `slots` say, with the sets `sets` in the file.
std::filesystem::path twoParts(const TemporaryFolder& folder, const std::vector<Json>& slots,
                               const std::vector<std::vector<int>>& sets)
{
    GltfBuilder file;
    EXPECT_TRUE(writePng(folder / "t.png", ImageRgba8(2, 2, u8vec4(200, 100, 50, 255))));
    file.json["images"] = {{{"uri", "t.png"}}};
    file.json["textures"] = {{{"source", 0}}};
    file.json["meshes"] = {{{"primitives", Json::array()}}};
    for (std::size_t p = 0; p < slots.size(); ++p) {
        Json attributes = {{"POSITION", file.floats({0, 0, float(p), 1, 0, float(p), 0, 1, float(p)}, "VEC3", 3)}};
        for (const int n : sets[p]) {
            const float f = 0.1f * float(n) + 0.5f * float(p); // each set and part in a place of its own
            attributes["TEXCOORD_" + std::to_string(n)] = file.floats({f, f, f + 0.1f, f, f, f + 0.1f}, "VEC2", 2);
        }
        file.json["meshes"][0]["primitives"].push_back({{"attributes", attributes}, {"material", p}});
        file.json["materials"].push_back({{"pbrMetallicRoughness", {{"baseColorTexture", slots[p]}}}});
    }
    file.json["nodes"] = {{{"mesh", 0}, {"name", "floor"}}};
    return file.write(folder);
}

/// Where the base colour texture of each corner of the scene is read; (0, 0) where the part lacks the set.
std::vector<vec2> textureCorners(const Scene& scene)
{
    std::vector<vec2> corners;
    for (const MeshPart& part : scene.meshes.at(0).parts) {
        const TextureRef& ref = scene.materials.at(std::size_t(part.material)).baseColorTexture;
        const std::vector<vec2>& uv = part.uv.at(std::size_t(ref.texCoord));
        for (const uint32_t i : part.indices) corners.push_back(uv.empty() ? vec2(0.0f) : uv[i]);
    }
    return corners;
}

/// As the unwrapper does where it keeps the file's layout.
BakedScene keepLayout(Scene scene)
{
    BakedScene baked = pretendToBake(std::move(scene), false);
    for (Mesh& mesh : baked.scene.meshes) {
        for (MeshPart& part : mesh.parts) {
            part.lightmapUv = part.uv[1];
            part.lightmapTexCoord = 1;
        }
    }
    return baked;
}

void expectKept(const std::filesystem::path& path, const TemporaryFolder& folder, bool keep)
{
    auto scene = readScene(path);
    ASSERT_TRUE(scene) << scene.error().text();
    const std::vector<vec2> before = textureCorners(*scene);
    for (const char* name : {"once.glb", "twice.glb"}) {
        const BakedScene baked = keep ? keepLayout(std::move(*scene)) : pretendToBake(std::move(*scene));
        const Status written = writeBakedScene(folder / name, baked);
        ASSERT_TRUE(written) << written.error().text();
        const auto read = readBakedScene(folder / name);
        ASSERT_TRUE(read) << read.error().text();
        EXPECT_EQ(textureCorners(read->scene), before) << name;
        expectSameTexels(baked.scene, baked.scene.objects.at(0), read->scene, read->scene.objects.at(0));
        scene = readScene(folder / name);
        ASSERT_TRUE(scene) << scene.error().text();
    }
}

TEST(TextureSets, SetOneIsReadByTheMaterialAndKeptForTheLightmap)
{
    const TemporaryFolder folder;
    const Json slot = {{"index", 0}, {"texCoord", 1}};
    expectKept(twoParts(folder, {slot, slot}, {{0, 1}, {0, 1}}), folder, true);
}

TEST(TextureSets, TransformNamesTheSetAndOnlyOnePartReadsIt)
{
    const TemporaryFolder folder;
    const Json transformed = {{"index", 0},
                              {"texCoord", 0},
                              {"extensions", {{"KHR_texture_transform", {{"texCoord", 1}, {"scale", {2, 3}}}}}}};
    expectKept(twoParts(folder, {transformed, {{"index", 0}}}, {{0, 1}, {0, 1}}), folder, true);
    expectKept(twoParts(folder, {{{"index", 0}}, transformed}, {{0, 1}, {0, 1}}), folder, false);
}

TEST(TextureSets, PartWithoutTheSetItsMaterialReadsStaysAtZero)
{
    const TemporaryFolder folder;
    const Json one = {{"index", 0}, {"texCoord", 1}};
    expectKept(twoParts(folder, {{{"index", 0}}, one}, {{}, {0}}), folder, false);
    expectKept(twoParts(folder, {one, {{"index", 0}}}, {{0, 1}, {}}), folder, false);
}

} // namespace
} // namespace halflight::texture_sets_test
