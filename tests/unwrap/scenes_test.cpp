// Every shared scene, judged by brute force.

#include "atlas_check.h"

#include "halflight/scene/gltf.h"

#include <filesystem>
#include <gtest/gtest.h>

namespace halflight::scenes_test {
namespace {

const std::filesystem::path kScenes = std::filesystem::path(HALFLIGHT_SHARED_DIR) / "scenes";

class UnwrapSharedScenes : public testing::TestWithParam<std::string> {};

TEST_P(UnwrapSharedScenes, NoTexelIsSharedByTwoCharts)
{
    const std::filesystem::path path = kScenes / GetParam();
    if (!std::filesystem::exists(path)) GTEST_SKIP() << "no shared scenes beside this checkout";
    const Result<Scene> scene = readScene(path, {.decodeTextures = false});
    ASSERT_TRUE(scene) << scene.error().text();
    bool authored = false;
    for (const Mesh& mesh : scene->meshes) {
        for (const MeshPart& part : mesh.parts) authored |= !part.uv[1].empty();
    }
    for (const UvMode mode : {UvMode::Auto, UvMode::Unwrap}) {
        if (mode == UvMode::Auto && !authored) continue; // the same thing
        UnwrapSettings settings;
        settings.uvMode = mode;
        const Result<UnwrappedScene> result = unwrap(*scene, settings);
        ASSERT_TRUE(result) << result.error().text();
        const AtlasCheck check = checkAtlas(*result, settings.paddingTexels);
        EXPECT_EQ(check.fault, "");
        EXPECT_EQ(checkMeshes(*scene, *result), "");
        EXPECT_EQ(result->pageCount, 1);
        EXPECT_LE(check.charts, result->chartCount); // charts may touch in a file's own layout, never in ours
        if (mode == UvMode::Unwrap) EXPECT_EQ(check.charts, result->chartCount);
        for (const Object& object : result->scene.objects)
            EXPECT_EQ(object.lightmap.page, object.isStatic ? 0 : -1) << object.name;
    }
}

std::vector<std::string> sceneNames()
{
    return {"alpha_blend_mode_test.glb",   "cornell_box_blend_nvidia.glb",
            "cornell_box_emissive.glb",    "cornell_box_lightmap_uv.glb",
            "cornell_box_point_light.glb", "dream_apartment_no_uv.glb",
            "grass_field_instanced.glb",   "grey_white_room.glb",
            "japanese_bridge_garden.glb",  "lights_all_types_playcanvas.glb",
            "lights_all_types_wicked.glb", "many_cubes.glb",
            "many_cubes_shared_mesh.glb",  "mixed_lighting_chair.glb",
            "negative_scale_zoo.glb",      "no_indices_building.glb",
            "primitive_zoo.glb",           "sponza_crytek.glb",
            "teapots_galore_instanced.glb"};
}

INSTANTIATE_TEST_SUITE_P(All, UnwrapSharedScenes, testing::ValuesIn(sceneNames()),
                         [](const auto& info) { return info.param.substr(0, info.param.find('.')); });

/// The list above is complete: a scene that is added to the folder has to be added there.
TEST(UnwrapSharedScenesList, NamesEveryScene)
{
    if (!std::filesystem::exists(kScenes)) GTEST_SKIP() << "no shared scenes beside this checkout";
    const std::vector<std::string> names = sceneNames();
    for (const auto& entry : std::filesystem::directory_iterator(kScenes)) {
        if (entry.path().extension() != ".glb" && entry.path().extension() != ".gltf") continue;
        EXPECT_NE(std::find(names.begin(), names.end(), entry.path().filename().string()), names.end()) << entry.path();
    }
}

} // namespace
} // namespace halflight::scenes_test
