// writeBakedScene() and readBakedScene(): what goes in comes out, bit for bit, and the rest of the file stays.

#include "fixtures.h"
#include <set>

#include <gmock/gmock.h>
#include <unistd.h>

namespace halflight::roundtrip_test {
namespace {

using namespace test;
const std::filesystem::path kScenes = std::filesystem::path(HALFLIGHT_SHARED_DIR) / "scenes";

void expectSamePages(const BakedScene& a, const BakedScene& b)
{
    ASSERT_EQ(a.lightmaps.size(), b.lightmaps.size());
    for (std::size_t i = 0; i < a.lightmaps.size(); ++i) {
        EXPECT_EQ(a.lightmaps[i].size(), b.lightmaps[i].size());
        EXPECT_EQ(a.lightmaps[i].texels(), b.lightmaps[i].texels());
    }
    ASSERT_EQ(a.lightmapDirections.size(), b.lightmapDirections.size());
    for (std::size_t i = 0; i < a.lightmapDirections.size(); ++i)
        EXPECT_EQ(a.lightmapDirections[i].texels(), b.lightmapDirections[i].texels());
    for (std::size_t i = 0; i < 4; ++i) {
        EXPECT_EQ(a.maskChannels[i].rangeTexels, b.maskChannels[i].rangeTexels);
        EXPECT_EQ(a.maskChannels[i].penumbraTexels, b.maskChannels[i].penumbraTexels);
    }
    ASSERT_EQ(a.shadowmasks.size(), b.shadowmasks.size());
    for (std::size_t i = 0; i < a.shadowmasks.size(); ++i)
        EXPECT_EQ(a.shadowmasks[i].texels(), b.shadowmasks[i].texels());
}

void expectSameProbes(const BakedScene& a, const BakedScene& b)
{
    ASSERT_EQ(a.probes.probes.size(), b.probes.probes.size());
    EXPECT_EQ(a.probes.origin, b.probes.origin);
    EXPECT_EQ(a.probes.spacingMeters, b.probes.spacingMeters);
    EXPECT_EQ(a.probes.size, b.probes.size);
    for (std::size_t i = 0; i < a.probes.probes.size(); ++i) {
        EXPECT_EQ(a.probes.probes[i].position, b.probes.probes[i].position);
        EXPECT_EQ(a.probes.probes[i].radiance, b.probes.probes[i].radiance);
        EXPECT_EQ(a.probes.probes[i].occlusion, b.probes.probes[i].occlusion);
        EXPECT_EQ(a.probes.probes[i].valid, b.probes.probes[i].valid);
    }
    ASSERT_EQ(a.reflections.probes.size(), b.reflections.probes.size());
    for (std::size_t i = 0; i < a.reflections.probes.size(); ++i) {
        EXPECT_EQ(a.reflections.probes[i].position, b.reflections.probes[i].position);
        EXPECT_EQ(a.reflections.probes[i].worldFromBox, b.reflections.probes[i].worldFromBox);
        EXPECT_EQ(a.reflections.probes[i].fadeMeters, b.reflections.probes[i].fadeMeters);
    }
    EXPECT_EQ(a.reflections.size, b.reflections.size);
    EXPECT_EQ(a.reflections.unitNits, b.reflections.unitNits);
    EXPECT_EQ(a.reflections.picture.texels(), b.reflections.picture.texels());
}

void expectSameLight(const Light& x, const Light& y)
{
    EXPECT_EQ(x.name, y.name);
    EXPECT_EQ(int(x.type), int(y.type));
    EXPECT_EQ(x.color, y.color);
    EXPECT_EQ(x.intensity, y.intensity);
    EXPECT_EQ(x.rangeMeters, y.rangeMeters);
    EXPECT_EQ(x.innerConeRadians, y.innerConeRadians);
    EXPECT_EQ(x.outerConeRadians, y.outerConeRadians);
    EXPECT_EQ(int(x.mode), int(y.mode));
    EXPECT_EQ(x.castShadows, y.castShadows);
    EXPECT_EQ(x.shadowStrength, y.shadowStrength);
    EXPECT_EQ(x.indirectMultiplier, y.indirectMultiplier);
    EXPECT_EQ(x.radiusMeters, y.radiusMeters);
    EXPECT_EQ(x.angularRadiusRadians, y.angularRadiusRadians);
    if (isAreaLight(x.type)) {
        EXPECT_EQ(x.sizeMeters, y.sizeMeters);
        EXPECT_EQ(x.baking.atBake.sizeMeters, y.baking.atBake.sizeMeters);
    }
    EXPECT_EQ(x.baking.isBaked, y.baking.isBaked);
    EXPECT_EQ(int(x.baking.bakeType), int(y.baking.bakeType));
    EXPECT_EQ(int(x.baking.mixedMode), int(y.baking.mixedMode));
    EXPECT_EQ(x.baking.occlusionMaskChannel, y.baking.occlusionMaskChannel);
    EXPECT_EQ(x.baking.reason, y.baking.reason);
    EXPECT_EQ(x.baking.worldFromLight, y.baking.worldFromLight);
}

void expectSameMesh(const Mesh& m, const Mesh& n)
{
    ASSERT_EQ(m.parts.size(), n.parts.size());
    for (std::size_t p = 0; p < m.parts.size(); ++p) {
        ASSERT_EQ(m.parts[p].positions, n.parts[p].positions);
        ASSERT_EQ(m.parts[p].indices, n.parts[p].indices);
        ASSERT_EQ(m.parts[p].uv[0], n.parts[p].uv[0]);
        ASSERT_EQ(m.parts[p].colors, n.parts[p].colors);
        ASSERT_EQ(m.parts[p].material, n.parts[p].material);
        ASSERT_EQ(m.parts[p].normals.size(), n.parts[p].normals.size());
        for (const uint32_t v : m.parts[p].indices) {
            ASSERT_LT(glm::distance(m.parts[p].normals[v], n.parts[p].normals[v]), 1.0e-6f);
        }
    }
}

void expectSameObject(const Scene& a, const Object& x, const Scene& b, const Object& y)
{
    ASSERT_EQ(x.name, y.name);
    EXPECT_EQ(x.isStatic, y.isStatic);
    EXPECT_EQ(x.castShadows, y.castShadows);
    EXPECT_EQ(x.receiveShadows, y.receiveShadows);
    EXPECT_EQ(x.lightmapScale, y.lightmapScale);
    EXPECT_EQ(int(x.probeLighting), int(y.probeLighting));
    EXPECT_EQ(x.probeResolution, y.probeResolution);
    EXPECT_EQ(x.probeGroup, y.probeGroup);
    expectSameTexels(a, x, b, y);
    expectSameMesh(a.meshes[std::size_t(x.mesh)], b.meshes[std::size_t(y.mesh)]);
}

void expectSameScene(const BakedScene& a, const BakedScene& b)
{
    EXPECT_EQ(a.scene.reflectionBoxes, b.scene.reflectionBoxes);
    EXPECT_EQ(a.scene.sky.zenith, b.scene.sky.zenith);
    EXPECT_EQ(a.scene.sky.horizon, b.scene.sky.horizon);
    EXPECT_EQ(a.scene.sky.ground, b.scene.sky.ground);
    EXPECT_EQ(a.scene.subtractiveShadowColor, b.scene.subtractiveShadowColor);
    EXPECT_EQ(subtractiveShadowColor(a), subtractiveShadowColor(b));
    EXPECT_EQ(a.scene.probePositions, b.scene.probePositions);
    EXPECT_EQ(a.scene.materials.size(), b.scene.materials.size());
    ASSERT_EQ(a.scene.lights.size(), b.scene.lights.size());
    for (std::size_t i = 0; i < a.scene.lights.size(); ++i) expectSameLight(a.scene.lights[i], b.scene.lights[i]);
    ASSERT_EQ(a.scene.objects.size(), b.scene.objects.size());
    for (std::size_t i = 0; i < a.scene.objects.size(); ++i)
        expectSameObject(a.scene, a.scene.objects[i], b.scene, b.scene.objects[i]);
}

void expectSame(const BakedScene& a, const BakedScene& b)
{
    EXPECT_EQ(a.isBaked, b.isBaked);
    EXPECT_EQ(int(a.mode), int(b.mode));
    EXPECT_EQ(a.lightmapUnitLux, b.lightmapUnitLux);
    expectSamePages(a, b);
    expectSameProbes(a, b);
    expectSameScene(a, b);
}

class RoundTrip : public testing::TestWithParam<const char*> {};

TEST_P(RoundTrip, BakedFileGivesBackTheBakeAndCanBeBakedAgain)
{
    const auto path = kScenes / GetParam();
    if (!std::filesystem::exists(path)) GTEST_SKIP() << "no shared scenes beside this checkout";
    auto scene = readScene(path, {.decodeTextures = false});
    ASSERT_TRUE(scene) << scene.error().text();
    const TemporaryFolder folder;
    const BakedScene baked = pretendToBake(*scene);
    const auto status = writeBakedScene(folder / "baked.glb", baked);
    ASSERT_TRUE(status) << status.error().text();
    const auto read = readBakedScene(folder / "baked.glb", {.decodeTextures = false});
    ASSERT_TRUE(read) << read.error().text();
    expectSame(baked, *read);

    // The same input gives the same bytes.
    ASSERT_TRUE(writeBakedScene(folder / "again.glb", baked));
    EXPECT_EQ(jsonOfGlb(folder / "baked.glb"), jsonOfGlb(folder / "again.glb"));

    // Baking the baked file: nothing piles up.
    const auto second = readScene(folder / "baked.glb", {.decodeTextures = false});
    ASSERT_TRUE(second) << second.error().text();
    EXPECT_EQ(second->materials.size(), scene->materials.size());
    for (const Light& light : second->lights) EXPECT_FALSE(light.baking.isBaked);
    const BakedScene rebaked = pretendToBake(*second, false);
    ASSERT_TRUE(writeBakedScene(folder / "rebaked.glb", rebaked));
    const auto reread = readBakedScene(folder / "rebaked.glb", {.decodeTextures = false});
    ASSERT_TRUE(reread) << reread.error().text();
    expectSame(rebaked, *reread);
    const Json first = jsonOfGlb(folder / "baked.glb");
    const Json again = jsonOfGlb(folder / "rebaked.glb");
    for (const char* array : {"accessors", "bufferViews", "meshes", "nodes", "materials", "textures", "images"}) {
        EXPECT_LE(again.value(array, Json::array()).size(), first.value(array, Json::array()).size()) << array;
    }
    const auto size = [&](const char* name) { return std::filesystem::file_size(folder / name); };
    EXPECT_LE(size("rebaked.glb"), size("baked.glb") + 4096);
}

TEST_P(RoundTrip, GltfWithFilesBesideItHoldsTheSame)
{
    const auto path = kScenes / GetParam();
    if (!std::filesystem::exists(path)) GTEST_SKIP() << "no shared scenes beside this checkout";
    auto scene = readScene(path);
    ASSERT_TRUE(scene) << scene.error().text();
    const std::size_t textures = scene->textures.size();
    const TemporaryFolder folder;
    const BakedScene baked = pretendToBake(std::move(*scene));
    const auto file = folder / "my bake 100%.gltf";
    ASSERT_TRUE(writeBakedScene(file, baked));
    const auto read = readBakedScene(file);
    ASSERT_TRUE(read) << read.error().text();
    expectSame(baked, *read);
    ASSERT_EQ(read->scene.textures.size(), textures);
    for (std::size_t t = 0; t < textures; ++t) {
        const auto before = baked.scene.textures[t].pixels.texels(), after = read->scene.textures[t].pixels.texels();
        EXPECT_TRUE(std::equal(before.begin(), before.end(), after.begin(), after.end())) << t;
    }
    // Images lie beside the document, not in its buffer; files are those it names.
    std::set<std::filesystem::path> named = {file};
    for (const auto& beside : externalFiles(read->scene)) named.insert(beside);
    std::set<std::filesystem::path> there;
    for (const auto& entry : std::filesystem::directory_iterator(file.parent_path())) there.insert(entry.path());
    EXPECT_EQ(named, there);
    EXPECT_EQ(textures == 0, there.size() == 2);

    // And can be baked again, into one file.
    ASSERT_TRUE(writeBakedScene(folder / "one.glb", pretendToBake(read->scene, false)));
    const auto one = readBakedScene(folder / "one.glb");
    ASSERT_TRUE(one) << one.error().text();
    EXPECT_EQ(one->scene.textures.size(), textures);
    EXPECT_TRUE(externalFiles(one->scene).empty());
}

INSTANTIATE_TEST_SUITE_P(Shared, RoundTrip,
                         testing::Values("sponza_crytek.glb", "grey_white_room.glb", "cornell_box_emissive.glb",
                                         "cornell_box_point_light.glb", "cornell_box_lightmap_uv.glb",
                                         "mixed_lighting_chair.glb", "lights_all_types_playcanvas.glb",
                                         "alpha_blend_mode_test.glb", "many_cubes_shared_mesh.glb",
                                         "grass_field_instanced.glb", "negative_scale_zoo.glb",
                                         "no_indices_building.glb", "primitive_zoo.glb"),
                         [](const auto& info) {
                             const std::string name = info.param;
                             return name.substr(0, name.find('.'));
                         });

TEST(WriteErrors, PartsOfAMeshDifferInTexCoord)
{
    const TemporaryFolder folder;
    BakedScene baked = pretendToBake(engineScene(), false);
    baked.scene.meshes[0].parts[1].lightmapTexCoord = 2;
    const Status status = writeBakedScene(folder / "baked.glb", baked);
    ASSERT_FALSE(status);
    EXPECT_EQ(status.error().code, ErrorCode::InvalidArgument);
    EXPECT_THAT(status.error().message, testing::HasSubstr("different TEXCOORD_n"));
    EXPECT_FALSE(std::filesystem::exists(folder / "baked.glb"));
}

} // namespace
} // namespace halflight::roundtrip_test
