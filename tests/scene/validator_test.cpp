// Written files pass the Khronos validator. Needs node and the npm module gltf-validator (NODE_PATH or
// HALFLIGHT_NODE_MODULES names the folder that holds it); skipped without.

#include "fixtures.h"
#include "validator.h"

namespace halflight::validator_test {
namespace {

using namespace test;
const std::filesystem::path kScenes = std::filesystem::path(HALFLIGHT_SHARED_DIR) / "scenes";

TEST(Validator, BakedSharedScenesHaveNoErrors)
{
    const TemporaryFolder folder;
    std::vector<std::filesystem::path> files;
    for (const char* name :
         {"sponza_crytek.glb", "grey_white_room.glb", "cornell_box_emissive.glb", "cornell_box_point_light.glb",
          "cornell_box_lightmap_uv.glb", "mixed_lighting_chair.glb", "lights_all_types_playcanvas.glb",
          "lights_all_types_wicked.glb", "alpha_blend_mode_test.glb", "many_cubes_shared_mesh.glb",
          "grass_field_instanced.glb", "negative_scale_zoo.glb", "no_indices_building.glb", "primitive_zoo.glb"}) {
        if (!std::filesystem::exists(kScenes / name)) GTEST_SKIP() << "no shared scenes beside this checkout";
        auto scene = readScene(kScenes / name, {.decodeTextures = false});
        ASSERT_TRUE(scene) << scene.error().text();
        ASSERT_TRUE(writeBakedScene(folder / name, pretendToBake(std::move(*scene))));
        files.push_back(folder / name);
        auto again = readScene(folder / name, {.decodeTextures = false});
        ASSERT_TRUE(again) << again.error().text();
        const BakedScene rebaked = pretendToBake(std::move(*again), false);
        const std::filesystem::path separate = folder / (files.back().stem().string() + "_again.gltf");
        ASSERT_TRUE(writeBakedScene(separate, rebaked));
        files.push_back(separate);
    }
    validate(files);
}

TEST(Validator, EngineFilledSceneHasNoErrors)
{
    const TemporaryFolder folder;
    ASSERT_TRUE(writeBakedScene(folder / "engine.glb", pretendToBake(engineScene(), false)));
    validate({folder / "engine.glb"});
}

} // namespace
} // namespace halflight::validator_test
