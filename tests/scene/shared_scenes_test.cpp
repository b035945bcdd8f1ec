// Every shared scene loads, with the counts that its README lists; every malformed file gives one clear sentence.

#include "halflight/scene/gltf.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace halflight::shared_scenes_test {
namespace {

const std::filesystem::path kScenes = std::filesystem::path(HALFLIGHT_SHARED_DIR) / "scenes";

struct Expected {
    const char* file;
    std::size_t triangles; // drawn
    std::size_t directional, point, spot;
    std::size_t materials;
    std::size_t emissiveMaterials;
    std::size_t instances; // mesh instances with at least one triangle
};

// README.md, columns "triangles (drawn)", "lights", "materials", "geometry".
const Expected kExpected[] = {
    {"sponza_crytek.glb", 262267, 1, 2, 1, 25, 0, 393},
    {"grey_white_room.glb", 105299, 1, 3, 0, 23, 1, 49},
    {"cornell_box_emissive.glb", 36, 0, 0, 0, 5, 1, 4},
    {"cornell_box_point_light.glb", 32, 0, 1, 0, 5, 0, 8},
    {"cornell_box_lightmap_uv.glb", 4006, 0, 0, 0, 7, 0, 4},
    {"cornell_box_blend_nvidia.glb", 16732, 0, 0, 0, 9, 1, 10},
    {"mixed_lighting_chair.glb", 40898, 1, 0, 0, 8, 0, 6},
    {"dream_apartment_no_uv.glb", 177934, 1, 2, 0, 67, 0, 1},
    {"japanese_bridge_garden.glb", 21883, 1, 0, 0, 13, 1, 1},
    {"lights_all_types_playcanvas.glb", 12, 1, 1, 2, 1, 0, 1},
    {"lights_all_types_wicked.glb", 14, 1, 1, 1, 1, 0, 2},
    {"alpha_blend_mode_test.glb", 61, 0, 0, 0, 6, 0, 9},
    {"many_cubes.glb", 6012, 0, 0, 0, 0, 0, 501},
    {"many_cubes_shared_mesh.glb", 6012, 0, 0, 0, 0, 0, 501},
    {"grass_field_instanced.glb", 1155872, 0, 0, 0, 2, 0, 3001},
    {"teapots_galore_instanced.glb", 7656770, 0, 0, 0, 3, 0, 1900},
    {"negative_scale_zoo.glb", 990, 1, 1, 0, 1, 0, 32},
    {"no_indices_building.glb", 72, 0, 0, 0, 0, 0, 3},
    {"primitive_zoo.glb", 84, 1, 1, 0, 15, 0, 0},
};

class SharedScenes : public testing::TestWithParam<Expected> {};

TEST_P(SharedScenes, LoadsWithTheListedCounts)
{
    const Expected& expected = GetParam();
    const auto path = kScenes / expected.file;
    if (!std::filesystem::exists(path)) GTEST_SKIP() << "no shared scenes beside this checkout";
    const auto scene = readScene(path);
    ASSERT_TRUE(scene) << scene.error().text();

    std::size_t triangles = 0;
    for (const Object& object : scene->objects) triangles += scene->meshes[std::size_t(object.mesh)].triangleCount();
    EXPECT_EQ(triangles, expected.triangles);
    std::size_t counts[3] = {};
    for (const Light& light : scene->lights) ++counts[int(light.type)];
    EXPECT_EQ(counts[int(LightType::Directional)], expected.directional);
    EXPECT_EQ(counts[int(LightType::Point)], expected.point);
    EXPECT_EQ(counts[int(LightType::Spot)], expected.spot);
    EXPECT_EQ(scene->materials.size(), expected.materials);
    std::size_t emissive = 0;
    for (const Material& material : scene->materials) emissive += material.emissiveNits != vec3(0.0f);
    EXPECT_EQ(emissive, expected.emissiveMaterials);
    if (expected.instances > 0) {
        EXPECT_EQ(scene->objects.size(), expected.instances);
    }

    // The promises of MeshPart and Scene, on real data.
    for (const Mesh& mesh : scene->meshes) {
        for (const MeshPart& part : mesh.parts) {
            const std::size_t n = part.positions.size();
            ASSERT_EQ(part.normals.size(), n);
            ASSERT_EQ(part.indices.size() % 3, 0u);
            for (const uint32_t index : part.indices) ASSERT_LT(index, n);
            for (std::size_t i = 0; i < n; ++i) {
                ASSERT_TRUE(std::isfinite(part.positions[i].x + part.positions[i].y + part.positions[i].z));
                ASSERT_NEAR(glm::length(part.normals[i]), 1.0f, 1.0e-4f);
            }
            for (const auto& uv : part.uv) ASSERT_TRUE(uv.empty() || uv.size() == n);
            ASSERT_TRUE(part.colors.empty() || part.colors.size() == n);
            ASSERT_TRUE(part.sourceVertex.empty() || part.sourceVertex.size() == n);
            const TextureRef& normal = materialOf(*scene, part).normalTexture;
            if (normal && !part.uv[std::size_t(normal.texCoord)].empty()) {
                ASSERT_EQ(part.tangents.size(), n);
                for (std::size_t i = 0; i < n; ++i) {
                    ASSERT_NEAR(glm::length(vec3(part.tangents[i])), 1.0f, 1.0e-4f);
                    ASSERT_EQ(std::abs(part.tangents[i].w), 1.0f);
                }
            }
        }
    }
    for (const Texture& texture : scene->textures) EXPECT_FALSE(texture.pixels.empty()) << texture.name;
    for (const Light& light : scene->lights) {
        EXPECT_NEAR(glm::determinant(mat3(light.worldFromLight)), 1.0f, 1.0e-4f) << light.name;
    }
    // Something shines in every scene, if only the sky that plain models get.
    EXPECT_TRUE(!scene->lights.empty() || emissive > 0 || !scene->sky.black());
}

INSTANTIATE_TEST_SUITE_P(Readme, SharedScenes, testing::ValuesIn(kExpected), [](const auto& info) {
    const std::string name = info.param.file;
    return name.substr(0, name.find('.'));
});

struct Malformed {
    const char* file;
    ErrorCode code;
    const char* object;  // glTF path of the offender
    const char* message; // part of the sentence
};

const Malformed kMalformed[] = {
    {"glb_empty_file.glb", ErrorCode::FileInvalid, "", "empty"},
    {"glb_invalid_magic.glb", ErrorCode::FileInvalid, "", "magic"},
    {"glb_chunk_too_big.glb", ErrorCode::FileInvalid, "", "13 bytes"},
    {"glb_truncated_chunk_data.glb", ErrorCode::FileInvalid, "", "cut short"},
    {"json_invalid_syntax.gltf", ErrorCode::FileInvalid, "", ""},
    {"asset_version_1_0.gltf", ErrorCode::Unsupported, "/asset/version", "1.0"},
    {"buffer_data_uri_wrong_length.gltf", ErrorCode::FileInvalid, "", ""},
    {"bufferview_out_of_range.gltf", ErrorCode::FileInvalid, "/bufferViews/", "past the end"},
    {"index_out_of_range.gltf", ErrorCode::FileInvalid, "/meshes/0/primitives/0", "beyond"},
    {"attribute_count_mismatch.gltf", ErrorCode::FileInvalid, "/meshes/0/primitives/0", "differ in length"},
    {"node_loop_scene.gltf", ErrorCode::FileInvalid, "/nodes/", ""},
    {"node_infinite_transform.gltf", ErrorCode::FileInvalid, "", ""},
    {"material_unresolved_texture.gltf", ErrorCode::FileInvalid, "/materials/0", "does not exist"},
    {"image_truncated_png.gltf", ErrorCode::FileInvalid, "/images/0", "image"},
    {"light_unresolved_index.gltf", ErrorCode::FileInvalid, "/nodes/0", "light that does not exist"},
    {"integer_overflow_byte_length.gltf", ErrorCode::FileInvalid, "/bufferViews/0/byteLength", "unsigned integer"},
    {"invalid_buffer_index.gltf", ErrorCode::FileInvalid, "/bufferViews/", "buffer 1 of 1"},
    {"positions_nan_inf.glb", ErrorCode::FileInvalid, "/accessors/", "not finite"},
};

class MalformedFiles : public testing::TestWithParam<Malformed> {};

TEST_P(MalformedFiles, GiveOneClearSentence)
{
    const Malformed& expected = GetParam();
    const auto path = kScenes / "malformed" / expected.file;
    if (!std::filesystem::exists(path)) GTEST_SKIP() << "no shared scenes beside this checkout";
    const auto scene = readScene(path);
    ASSERT_FALSE(scene);
    const Error& error = scene.error();
    EXPECT_EQ(int(error.code), int(expected.code)) << error.text();
    EXPECT_THAT(error.object, testing::StartsWith(expected.object)) << error.text();
    EXPECT_THAT(error.message, testing::HasSubstr(expected.message)) << error.text();
    EXPECT_GT(error.message.size(), 10u) << error.text();
    EXPECT_EQ(error.text().find('\n'), std::string::npos) << error.text();
    RecordProperty("sentence", error.text());
}

INSTANTIATE_TEST_SUITE_P(Shared, MalformedFiles, testing::ValuesIn(kMalformed), [](const auto& info) {
    const std::string name = info.param.file;
    return name.substr(0, name.find('.'));
});

TEST(MalformedFiles, RequiredMeshoptIsRead)
{
    const auto path = kScenes / "malformed" / "required_ext_meshopt_box.glb";
    if (!std::filesystem::exists(path)) GTEST_SKIP() << "no shared scenes beside this checkout";
    const auto scene = readScene(path);
    ASSERT_TRUE(scene) << scene.error().text();
    ASSERT_EQ(scene->meshes.size(), 1u);
    EXPECT_EQ(scene->meshes[0].parts.at(0).indices.size(), 36u); // a box of twelve triangles
}

TEST(MalformedFiles, OddButValidPrimitiveIsSkipped)
{
    const auto path = kScenes / "malformed" / "primitive_no_position.gltf";
    if (!std::filesystem::exists(path)) GTEST_SKIP() << "no shared scenes beside this checkout";
    const auto scene = readScene(path);
    ASSERT_TRUE(scene) << scene.error().text();
    EXPECT_TRUE(scene->objects.empty());
    EXPECT_THAT(scene->warnings, testing::Contains(testing::HasSubstr("no positions")));
}

TEST(MalformedFiles, MissingFileAndFolder)
{
    EXPECT_EQ(readScene("/nonexistent/scene.glb").error().code, ErrorCode::FileNotFound);
    EXPECT_EQ(readScene(std::filesystem::temp_directory_path()).error().code, ErrorCode::FileNotFound);
}

} // namespace
} // namespace halflight::shared_scenes_test
