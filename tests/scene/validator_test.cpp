// Written files pass the Khronos validator. Needs node and the npm module gltf-validator (NODE_PATH or
// HALFLIGHT_NODE_MODULES names the folder that holds it); skipped without.

#include "fixtures.h"

#include <array>
#include <cstdio>

namespace halflight {
namespace {

using namespace test;
const std::filesystem::path kScenes = std::filesystem::path(HALFLIGHT_SHARED_DIR) / "scenes";

int run(const std::string& command, std::string& output)
{
    FILE* pipe = ::popen(command.c_str(), "r");
    if (pipe == nullptr) return -1;
    std::array<char, 4096> buffer;
    while (const std::size_t n = std::fread(buffer.data(), 1, buffer.size(), pipe)) output.append(buffer.data(), n);
    const int status = ::pclose(pipe);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

// Runs the validator and checks that no file has an error, and that all warnings are of the kinds docs/format.md lists.
void validate(const std::vector<std::filesystem::path>& files)
{
    std::string output;
    if (run("node --version 2>/dev/null", output) != 0) GTEST_SKIP() << "node is not installed";
    std::string command = std::string("node '") + HALFLIGHT_SOURCE_DIR + "/tests/scene/validate_gltf.js'";
    for (const auto& file : files) command += " '" + file.string() + "'";
    output.clear();
    const int exitCode = run(command + " 2>&1", output);
    if (exitCode == 3) GTEST_SKIP() << output;
    ASSERT_TRUE(exitCode == 0 || exitCode == 1) << output;
    const Json report = Json::parse(output);
    ASSERT_EQ(report.size(), files.size());
    for (const auto& [name, result] : report.items()) {
        EXPECT_EQ(result["numErrors"], 0) << name << "\n" << result["errors"].dump(1).substr(0, 3000);
        for (const auto& [code, count] : result["warnings"].items()) {
            const bool known = code == "UNSUPPORTED_EXTENSION" || code == "VALUE_NOT_IN_LIST" ||
                               code == "IMAGE_UNRECOGNIZED_FORMAT" || code == "MESH_PRIMITIVE_GENERATED_TANGENT_SPACE";
            EXPECT_TRUE(known) << name << ": " << code << " x " << count;
        }
    }
    if (testing::Test::HasFailure()) return;
    testing::Test::RecordProperty("report", output);
}

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
        ASSERT_TRUE(writeBakedScene(folder / ("again_" + std::string(name)), pretendToBake(std::move(*again), false)));
        files.push_back(folder / ("again_" + std::string(name)));
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
} // namespace halflight
