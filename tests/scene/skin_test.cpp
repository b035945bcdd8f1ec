// Skinned meshes are where their joints put them at rest, morphed ones have the weights of their node.

#include "fixtures.h"

#include <functional>
#include <gmock/gmock.h>

namespace halflight::skin_test {
namespace {

using namespace test;
using testing::HasSubstr;

constexpr float kHalf = 0.70710678f; // of a quarter turn's quaternion

std::vector<vec3> worldCorners(const Scene& scene, const std::string& name)
{
    std::vector<vec3> corners;
    for (const Object& object : scene.objects) {
        if (object.name != name) continue;
        for (const MeshPart& part : scene.meshes[std::size_t(object.mesh)].parts) {
            for (const uint32_t i : part.indices)
                corners.emplace_back(object.worldFromObject * vec4(part.positions[i], 1.0f));
        }
    }
    return corners;
}

void expectNear(const std::vector<vec3>& a, const std::vector<vec3>& b)
{
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) EXPECT_LT(glm::distance(a[i], b[i]), 1.0e-5f) << i;
}

/// A triangle (0,0,0) (1,0,0) (0,1,0) with a floor's, node 0 "skinned" below node 1, joints 2 and 3.
struct SkinnedFile : GltfBuilder {
    SkinnedFile()
    {
        json["meshes"] = {{{"primitives",
                            {{{"attributes",
                               {{"POSITION", floats({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3", 3)},
                                {"NORMAL", floats({0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3", 3)},
                                {"JOINTS_0", accessor<uint8_t>({0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0}, 5121, "VEC4", 4)},
                                {"WEIGHTS_0", floats({1, 0, 0, 0, 1, 0, 0, 0, 0.5, 0.5, 0, 0}, "VEC4", 4)}}}}}}}};
        json["nodes"] = {{{"name", "skinned"}, {"mesh", 0}, {"skin", 0}, {"translation", {0, 9, 0}}},
                         {{"children", {0}}, {"translation", {7, 0, 0}}},
                         {{"translation", {-1.5, 0.5, 0}}},
                         {{"translation", {2, 0, 0}}, {"rotation", {0, 0, kHalf, kHalf}}}};
        json["scenes"] = {{{"nodes", {1, 2, 3}}}};
        json["skins"] = {{{"joints", {2, 3}}}};
    }
    Json& attributes() { return json["meshes"][0]["primitives"][0]["attributes"]; }
};

// Vertex 0 follows joint 0, vertex 1 joint 1 (a quarter turn about z), vertex 2 both to the half.
const std::vector<vec3> kExpected = {{-1.5f, 0.5f, 0}, {2, 1, 0}, {0.5f * (-1.5f + 1), 0.5f * (1.5f + 0), 0}};

Scene readOrDie(const std::filesystem::path& path)
{
    auto scene = readScene(path);
    EXPECT_TRUE(scene) << scene.error().text();
    return scene ? std::move(*scene) : Scene();
}

TEST(SkinAtRest, JointsPlaceTheMeshAndItsOwnNodeDoesNot)
{
    const TemporaryFolder folder;
    for (const Json& scale : {Json{1, 1, 1}, Json{0, 0, 0}, Json{3, -2, 1}}) {
        SkinnedFile file;
        file.json["nodes"][0]["scale"] = scale;
        const Scene scene = readOrDie(file.write(folder));
        expectNear(worldCorners(scene, "skinned"), kExpected);
        EXPECT_FALSE(scene.objects.at(0).isStatic);
        for (const vec3& n : scene.meshes.at(0).parts.at(0).normals) EXPECT_LT(glm::distance(n, vec3(0, 0, 1)), 1e-6f);
    }
}

TEST(SkinAtRest, IntegerWeightsSecondSetAndInverseBindMatrices)
{
    const TemporaryFolder folder;
    SkinnedFile file;
    // The same weights as integers, the second joint's in the second set.
    file.attributes()["JOINTS_0"] = file.accessor<uint16_t>(std::vector<uint16_t>(12, 0), 5123, "VEC4", 4);
    file.attributes()["WEIGHTS_0"] =
        file.accessor<uint8_t>({255, 0, 0, 0, 0, 0, 0, 0, 100, 0, 0, 0}, 5121, "VEC4", 4, true);
    file.attributes()["JOINTS_1"] = file.accessor<uint8_t>({0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}, 5121, "VEC4", 4);
    file.attributes()["WEIGHTS_1"] =
        file.accessor<uint16_t>({0, 0, 0, 0, 0, 65535, 0, 0, 0, 0, 25700, 0}, 5123, "VEC4", 4, true);
    expectNear(worldCorners(readOrDie(file.write(folder)), "skinned"), kExpected);
    // Inverse bind matrices that move by (0, 0, 5) and scale by 2, columns first.
    file.json["skins"][0]["inverseBindMatrices"] = file.floats(
        {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 5, 1, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1}, "MAT4", 16);
    expectNear(worldCorners(readOrDie(file.write(folder)), "skinned"),
               {{-1.5f, 0.5f, 5}, {2, 2, 0}, {0.5f * (-1.5f + 0), 0.5f * (1.5f + 0), 2.5f}});
}

TEST(SkinAtRest, MirroringJointsTurnTheWinding)
{
    const TemporaryFolder folder;
    SkinnedFile file;
    file.json["nodes"][2]["scale"] = {1, 1, -1};
    file.json["nodes"][3] = file.json["nodes"][2];
    const Scene scene = readOrDie(file.write(folder));
    const std::vector<vec3> p = worldCorners(scene, "skinned");
    expectNear(p, {{-1.5f, 0.5f, 0}, {-0.5f, 0.5f, 0}, {-1.5f, 1.5f, 0}});
    // Front faces of a mirrored object are clockwise; its normals follow the inverse transpose.
    const Object& object = scene.objects.at(0);
    EXPECT_LT(glm::determinant(mat3(object.worldFromObject)), 0.0f);
    const vec3 n = glm::transpose(glm::inverse(mat3(object.worldFromObject))) * scene.meshes[0].parts[0].normals[0];
    EXPECT_LT(glm::distance(n, vec3(0, 0, -1)), 1e-5f);
}

TEST(SkinAtRest, WriterLeavesTheSkinAndABakedFileIsTheSame)
{
    const TemporaryFolder folder;
    for (const bool isStatic : {false, true}) {
        SkinnedFile file;
        file.json["nodes"][0]["extras"]["halflight_static"] = isStatic;
        // The same mesh twice: once without its skin.
        file.json["nodes"].push_back({{"name", "plain"}, {"mesh", 0}});
        file.json["scenes"][0]["nodes"].push_back(4);
        const Scene scene = readOrDie(file.write(folder));
        ASSERT_EQ(scene.objects.size(), 2u);
        BakedScene baked = pretendToBake(scene);
        if (!isStatic) { // a bake unwraps static objects alone
            for (MeshPart& part : baked.scene.meshes[std::size_t(baked.scene.objects[0].mesh)].parts)
                part.lightmapUv.clear();
        }
        const Status written = writeBakedScene(folder / "baked.glb", baked);
        ASSERT_TRUE(written) << written.error().text();
        const Json json = jsonOfGlb(folder / "baked.glb");
        EXPECT_EQ(json["nodes"][0]["skin"], 0);
        EXPECT_EQ(json["nodes"][0]["translation"], file.json["nodes"][0]["translation"]);
        EXPECT_EQ(json["skins"], file.json["skins"]);
        const Json& mesh = json["meshes"][json["nodes"][0]["mesh"].get<std::size_t>()];
        EXPECT_TRUE(mesh["primitives"][0]["attributes"].contains("WEIGHTS_0"));
        EXPECT_EQ(mesh["primitives"][0]["attributes"].contains("TEXCOORD_1"), isStatic);
        EXPECT_EQ(json["meshes"].size(), 2u);
        const auto read = readBakedScene(folder / "baked.glb");
        ASSERT_TRUE(read) << read.error().text();
        for (const char* name : {"skinned", "plain"})
            expectNear(worldCorners(read->scene, name), worldCorners(baked.scene, name));
        expectNear(worldCorners(read->scene, "skinned"), kExpected);
        EXPECT_THAT(read->scene.warnings, testing::Not(testing::Contains(HasSubstr("stale"))));
    }
}

TEST(SkinAtRest, BrokenSkinsAreNamed)
{
    const TemporaryFolder folder;
    SkinnedFile beyond;
    beyond.json["skins"][0]["joints"] = {2};
    const Scene scene = readOrDie(beyond.write(folder));
    EXPECT_THAT(scene.warnings, testing::Contains(HasSubstr("/nodes/0: 2 weights name joints")));
    EXPECT_LT(glm::distance(worldCorners(scene, "skinned").at(2), vec3(-1.5f, 1.5f, 0)), 1e-5f);
    const auto errorOf = [&](const std::function<void(SkinnedFile&)>& damage) {
        SkinnedFile file;
        damage(file);
        const auto read = readScene(file.write(folder));
        return read ? std::string("loaded") : read.error().text();
    };
    EXPECT_THAT(errorOf([](auto& f) {
                    f.json["skins"][0]["joints"] = {2, 77};
                }),
                HasSubstr("/skins/0: refers to node 77"));
    EXPECT_THAT(errorOf([](auto& f) { f.json["skins"][0]["inverseBindMatrices"] = f.attributes()["NORMAL"]; }),
                HasSubstr("/skins/0: inverseBindMatrices are not"));
    EXPECT_THAT(errorOf([](auto& f) { f.attributes()["JOINTS_0"] = f.attributes()["WEIGHTS_0"]; }),
                HasSubstr("/meshes/0/primitives/0: JOINTS_0"));
    // Finite in double precision, not in the floats that a mesh holds.
    EXPECT_THAT(errorOf([](auto& f) {
                    std::vector<float> matrices(32, 0.0f);
                    for (const std::size_t i : {0u, 5u, 10u, 15u, 16u, 21u, 26u, 31u}) matrices[i] = 1.0f;
                    matrices[0] = 3.0e38f;
                    matrices[16] = 3.0e38f;
                    f.json["skins"][0]["inverseBindMatrices"] = f.floats(matrices, "MAT4", 16);
                    f.json["nodes"][3]["scale"] = {100, 100, 100};
                }),
                HasSubstr("/nodes/0: its skin puts a vertex where numbers end"));
}

TEST(MorphWeights, OfTheNodeOverrideThoseOfTheMesh)
{
    const TemporaryFolder folder;
    GltfBuilder file;
    file.triangle();
    file.json["meshes"][0]["primitives"][0]["targets"] = {
        {{"POSITION", file.floats({0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3", 3)}}};
    file.json["meshes"][0]["weights"] = {0.25};
    file.json["nodes"] = {{{"mesh", 0}, {"name", "own"}, {"weights", {2}}},
                          {{"mesh", 0}, {"name", "default"}},
                          {{"mesh", 0}, {"name", "none"}, {"weights", {0}}},
                          {{"mesh", 0}, {"name", "shared"}, {"weights", {0.25}}}};
    file.json["scenes"] = {{{"nodes", {0, 1, 2, 3}}}};
    const Scene scene = readOrDie(file.write(folder));
    EXPECT_EQ(scene.meshes.size(), 3u);
    const auto heights = [](const Scene& of) {
        std::vector<float> z;
        for (const Object& object : of.objects) z.push_back(worldCorners(of, object.name).at(1).z);
        return z;
    };
    EXPECT_EQ(heights(scene), (std::vector<float>{2.0f, 0.25f, 0.0f, 0.25f}));
    const Status written = writeBakedScene(folder / "baked.glb", pretendToBake(scene));
    ASSERT_TRUE(written) << written.error().text();
    const auto read = readBakedScene(folder / "baked.glb");
    ASSERT_TRUE(read) << read.error().text();
    EXPECT_EQ(heights(read->scene), heights(scene));
}

} // namespace
} // namespace halflight::skin_test
