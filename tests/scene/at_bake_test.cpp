// What a bake saw of a scene: what tools do to a file leaves it true, what an author changes does not.

#include "fixtures.h"

#include "scene/format/at_bake.h"

#include <algorithm>
#include <functional>
#include <gmock/gmock.h>
#include <numeric>

namespace halflight::at_bake_test {
namespace {

using namespace test;
using testing::HasSubstr;
using testing::IsEmpty;

/// A bumpy square of 6 m with 32 x 32 x 2 triangles and a texture of noise.
Scene bumpyScene()
{
    Scene scene = engineScene();
    constexpr int kSide = 32;
    MeshPart part;
    part.material = 0;
    for (int y = 0; y <= kSide; ++y) {
        for (int x = 0; x <= kSide; ++x) {
            const vec2 place = vec2(float(x), float(y)) / float(kSide);
            part.positions.emplace_back(6.0f * place.x, 0.3f * std::sin(9.0f * place.x * place.y), 6.0f * place.y);
            part.uv[0].push_back(3.0f * place);
        }
    }
    part.normals.assign(part.positions.size(), vec3(0, 1, 0));
    for (int y = 0; y < kSide; ++y) {
        for (int x = 0; x < kSide; ++x) {
            const auto corner = uint32_t(y * (kSide + 1) + x);
            const uint32_t below = corner + kSide + 1;
            part.indices.insert(part.indices.end(), {corner, below, corner + 1, corner + 1, below, below + 1});
        }
    }
    scene.meshes[0].parts = {part};
    ImageRgba8& pixels = scene.textures[0].pixels.edit();
    pixels = ImageRgba8(512, 512);
    for (std::size_t i = 0; i < pixels.texelCount(); ++i) {
        const uint32_t h = hashPcg(uint32_t(i));
        pixels.texels()[i] = u8vec4(h & 255, h >> 8 & 255, 100, 255);
    }
    scene.materials[0].alphaMode = Material::AlphaMode::Opaque;
    return scene;
}

SurfaceAtBake surfaceOf(const Scene& scene)
{
    const Object* object = &scene.objects[0];
    return AtBake(scene).ofObjects(std::span(&object, 1)).value();
}

bool differsAfter(const std::function<void(Scene&)>& change)
{
    const Scene before = bumpyScene();
    Scene after = before;
    change(after);
    // As a file keeps it.
    const auto stored = SurfaceAtBake::from(Json::parse(surfaceOf(before).json().dump()), glm::dvec3(0.0));
    EXPECT_TRUE(stored.has_value());
    return surfaceOf(after).differsFrom(*stored);
}

MeshPart& partOf(Scene& scene)
{
    return scene.meshes[0].parts[0];
}

TEST(SurfaceAtBake, IsWhatGeometrySays)
{
    const Scene scene = engineScene(); // a unit square in z = 0, twice, at (0, 2, 0)
    const Object* object = &scene.objects[0];
    const SurfaceAtBake surface = AtBake(scene).ofObjects(std::span(&object, 1)).value();
    EXPECT_NEAR(surface.area, 2.0f, 1.0e-5f);
    EXPECT_NEAR(surface.centroid.y, 2.5f, 1.0e-5f);
    EXPECT_NEAR(surface.spread.x, std::sqrt(1.0f / 12.0f), 1.0e-5f);
    EXPECT_NEAR(surface.spread.z, 0.0f, 1.0e-5f);
    EXPECT_EQ(surface.switches[1], 0.5f) << "one of two materials receives no shadows";
    EXPECT_NEAR(surface.emission.y, 0.5f * std::pow(5.0f, 1.0f / 2.2f), 1.0e-3f);
}

TEST(SurfaceAtBake, StaysWhatToolsDo)
{
    EXPECT_FALSE(differsAfter([](Scene&) {}));
    EXPECT_FALSE(differsAfter([](Scene& scene) { // 14 bits of the mesh's extent
        for (vec3& p : partOf(scene).positions) p = glm::round(p * (16383.0f / 6.0f)) * (6.0f / 16383.0f);
    }));
    EXPECT_FALSE(differsAfter([](Scene& scene) { // other order of vertices and triangles
        MeshPart& part = partOf(scene);
        const auto last = uint32_t(part.positions.size() - 1);
        std::reverse(part.positions.begin(), part.positions.end());
        std::reverse(part.uv[0].begin(), part.uv[0].end());
        for (uint32_t& index : part.indices) index = last - index;
        std::rotate(part.indices.begin(), part.indices.begin() + 99, part.indices.end());
    }));
    EXPECT_FALSE(differsAfter([](Scene& scene) { // textures at half the size, with errors of a lossy codec
        const ImageRgba8 full = scene.textures[0].pixels;
        ImageRgba8 half(256, 256);
        for (int y = 0; y < 256; ++y) {
            for (int x = 0; x < 256; ++x) {
                const ivec4 sum = ivec4(full(2 * x, 2 * y)) + ivec4(full(2 * x + 1, 2 * y)) +
                                  ivec4(full(2 * x, 2 * y + 1)) + ivec4(full(2 * x + 1, 2 * y + 1));
                const int error = int(hashPcg(uint32_t(x + 256 * y)) % 11) - 5;
                half(x, y) = u8vec4(glm::clamp(sum / 4 + ivec4(error, error, error, 0), 0, 255));
            }
        }
        scene.textures[0].pixels = half;
    }));
    EXPECT_FALSE(differsAfter([](Scene& scene) { scene.textures[0].pixels = {}; })) << "not decoded: geometry counts";
}

TEST(SurfaceAtBake, DiffersAfterWhatAuthorsDo)
{
    EXPECT_TRUE(differsAfter([](Scene& scene) { scene.objects[0].worldFromObject[3].x += 0.01f; }));
    EXPECT_TRUE(differsAfter([](Scene& scene) { scene.objects[0].worldFromObject[1] *= 1.1f; }));
    EXPECT_TRUE(differsAfter([](Scene& scene) { partOf(scene).indices.resize(partOf(scene).indices.size() / 2); }));
    EXPECT_TRUE(differsAfter([](Scene& scene) { partOf(scene).positions[100].y += 2.0f; }));
    EXPECT_TRUE(differsAfter([](Scene& scene) { scene.materials[0].baseColor *= 0.7f; }));
    EXPECT_TRUE(differsAfter([](Scene& scene) { scene.materials[0].emissiveNits *= 1.2f; }));
    EXPECT_TRUE(differsAfter([](Scene& scene) { scene.materials[0].metallic = 0.9f; }));
    EXPECT_TRUE(differsAfter([](Scene& scene) { scene.materials[0].doubleSided = false; }));
    EXPECT_TRUE(differsAfter([](Scene& scene) { scene.objects[0].castShadows = false; }));
    EXPECT_TRUE(differsAfter([](Scene& scene) { // a wall painted over
        for (u8vec4& texel : scene.textures[0].pixels.edit().texels()) texel = u8vec4(200, 60, 100, 255);
    }));
}

TEST(SurfaceAtBake, AFlatColorMayMoveIntoATexture)
{
    const Scene before = bumpyScene();
    Scene plain = before;
    plain.materials[0].baseColorTexture = {};
    plain.materials[0].baseColor = {0.5f, 0.1f, 0.8f, 1.0f};
    Scene palette = plain;
    palette.materials[0].baseColor = vec4(1.0f);
    palette.materials[0].baseColorTexture.texture = 0;
    palette.textures[0].pixels = ImageRgba8(4, 4, u8vec4(188, 89, 231, 255)); // the same in sRGB
    EXPECT_FALSE(surfaceOf(palette).differsFrom(surfaceOf(plain)));
}

class LostBake : public testing::Test {
protected:
    void SetUp() override
    {
        BakedScene baked = pretendToBake(engineScene(), false);
        baked.scene.warnings.clear();
        ASSERT_TRUE(writeBakedScene(folder / "baked.glb", baked));
    }
    BakedScene after(const std::function<void(Json&)>& change)
    {
        std::vector<char> binary;
        Json json = jsonOfGlb(folder / "baked.glb", &binary);
        change(json);
        json["buffers"][0]["uri"] = "binary.bin";
        writeText(folder / "binary.bin", std::string(binary.begin(), binary.end()));
        writeText(folder / "changed.gltf", json.dump());
        Result<BakedScene> read = readBakedScene(folder / "changed.gltf");
        EXPECT_TRUE(read) << read.error().text();
        return read ? *read : BakedScene();
    }
    TemporaryFolder folder;
};

TEST_F(LostBake, NothingIsLostOfAnUntouchedFile)
{
    EXPECT_THAT(after([](Json&) {}).lost, IsEmpty());
}

TEST_F(LostBake, AllExtensionsDropped)
{
    const BakedScene read = after([](Json& json) {
        json.erase("extensions");
        for (Json& node : json["nodes"]) node.erase("extensions");
    });
    EXPECT_FALSE(read.isBaked);
    EXPECT_THAT(read.lost, testing::ElementsAre(HasSubstr("all of it (shadowmask, 2 lightmapped objects")));
    EXPECT_THAT(read.scene.warnings, testing::Contains(HasSubstr("has lost part of its bake: all of it")));
}

TEST_F(LostBake, RecordsOfNodesDropped)
{
    const BakedScene read = after([](Json& json) {
        for (Json& node : json["nodes"]) {
            if (node.value("name", "") == "quad 1") node.erase("extensions");
        }
    });
    EXPECT_THAT(read.lost, testing::Contains(HasSubstr("1 of 2 objects' places in the lightmap")));
    EXPECT_THAT(read.lost, testing::Contains(HasSubstr("the records of objects \"quad 1\"")));
}

TEST_F(LostBake, LightmapCoordinatesDropped)
{
    const BakedScene read = after([](Json& json) {
        for (Json& mesh : json["meshes"]) {
            for (Json& primitive : mesh["primitives"]) primitive["attributes"].erase("TEXCOORD_1");
        }
    });
    EXPECT_THAT(read.lost, testing::Contains(HasSubstr("the lightmap coordinates of objects \"quad 0\", \"quad 1\"")));
    for (const Object& object : read.scene.objects) EXPECT_EQ(object.lightmap.page, -1);
}

TEST_F(LostBake, LightsDropped)
{
    const BakedScene read = after([](Json& json) {
        for (Json& node : json["nodes"]) {
            if (node.contains("extensions") && node["extensions"].contains("HALFLIGHT_light"))
                node["extensions"].erase("HALFLIGHT_light");
        }
    });
    EXPECT_THAT(read.lost, testing::Contains(HasSubstr("5 of 5 baked lights")));
}

} // namespace
} // namespace halflight::at_bake_test
