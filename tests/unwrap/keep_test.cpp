// Layouts of the file's own, and what vertices keep.

#include "shapes.h"
#include "unwrap_and_check.h"

#include <cmath>
#include <functional>
#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>
#include <utility>

namespace halflight::unwrap_keep_test {
namespace {

using namespace unwrap_test;

TEST(UnwrapVertices, SourceVertexIsComposed)
{
    Mesh mesh = shapes::sphere(1.0f, 16, 32);
    MeshPart& part = mesh.parts[0];
    const auto count = uint32_t(part.positions.size());
    for (uint32_t v = 0; v < count; ++v) part.sourceVertex.push_back(1000 - v); // as a reader may have left it
    part.uv[0].resize(count);
    part.tangents.resize(count);
    part.colors.resize(count);
    for (uint32_t v = 0; v < count; ++v) part.colors[v] = vec4(float(v));
    const UnwrappedScene result = unwrapAndCheck(shapes::scene(mesh));
    const MeshPart& after = result.scene.meshes[0].parts[0];
    EXPECT_GT(after.positions.size(), part.positions.size()); // it was cut
    ASSERT_EQ(after.sourceVertex.size(), after.positions.size());
    for (std::size_t v = 0; v < after.positions.size(); ++v)
        EXPECT_EQ(after.sourceVertex[v], 1000 - uint32_t(after.colors[v].x));
}

TEST(UnwrapVertices, LightmapTexCoordIsOneThatAllMaterialsOfTheMeshLeaveFree)
{
    Scene scene = shapes::scene(shapes::together(shapes::plane(), shapes::box()));
    scene.materials.resize(2);
    scene.materials[1].emissiveTexture.texture = 0;
    scene.materials[1].emissiveTexture.texCoord = 1;
    scene.textures.resize(1);
    scene.meshes[0].parts[0].material = 1;
    scene.meshes[0].parts[1].material = 0;
    for (const int last : {1, 0}) { // whichever part has that material
        std::swap(scene.meshes[0].parts[0].material, scene.meshes[0].parts[1].material);
        const UnwrappedScene result = unwrapAndCheck(scene);
        for (const MeshPart& part : result.scene.meshes[0].parts) EXPECT_EQ(part.lightmapTexCoord, 2) << last;
    }
    // The reader knows of textures that the scene does not hold.
    for (MeshPart& part : scene.meshes[0].parts) part.lightmapTexCoord = 3;
    const UnwrappedScene result = unwrapAndCheck(scene);
    for (const MeshPart& part : result.scene.meshes[0].parts) EXPECT_EQ(part.lightmapTexCoord, 3);
}

/// A plane with TEXCOORD_1 filling a rectangle of the uv square.
Mesh planeWithUv(vec2 from, vec2 to)
{
    Mesh mesh = shapes::plane(1.0f, 1.0f, 4);
    for (const vec3 p : mesh.parts[0].positions)
        mesh.parts[0].uv[1].push_back(glm::mix(from, to, vec2(p.x + 0.5f, p.z + 0.5f)));
    return mesh;
}

TEST(UnwrapKeep, AtlasThatDoesNotOverlapStaysAsItIs)
{
    Scene scene = shapes::scene(planeWithUv({0.0f, 0.0f}, {0.45f, 0.45f}));
    scene.meshes.push_back(planeWithUv({0.5f, 0.0f}, {0.9f, 0.4f}));
    shapes::add(scene, 1, mat4(1.0f));
    for (const UvMode mode : {UvMode::Keep, UvMode::Auto}) {
        UnwrapSettings settings;
        settings.uvMode = mode;
        settings.pageSize = 512;
        const UnwrappedScene result = unwrapAndCheck(scene, settings);
        EXPECT_EQ(result.pageSize, 512);
        EXPECT_EQ(result.pageCount, 1);
        for (std::size_t o = 0; o < 2; ++o) {
            EXPECT_TRUE(result.meshes[o].kept);
            EXPECT_EQ(result.scene.objects[o].lightmap.scale, vec2(1.0f));
            EXPECT_EQ(result.scene.objects[o].lightmap.offset, vec2(0.0f));
            EXPECT_EQ(result.scene.meshes[o].parts[0].lightmapUv, scene.meshes[o].parts[0].uv[1]);
        }
        EXPECT_NEAR(result.texelsPerMeter, 512.0 * std::sqrt((0.45 * 0.45 + 0.4 * 0.4) / 2.0), 0.1);
    }
}

TEST(UnwrapKeep, LayoutsThatOverlapOneAnotherArePacked)
{
    Scene scene = shapes::scene(planeWithUv({0.1f, 0.1f}, {0.9f, 0.9f}));
    shapes::add(scene, 0, glm::scale(mat4(1.0f), vec3(2.0f)));
    scene.meshes.push_back(planeWithUv({0.0f, 0.0f}, {1.0f, 1.0f}));
    shapes::add(scene, 1, mat4(1.0f));
    UnwrapSettings settings;
    settings.uvMode = UvMode::Keep;
    settings.texelsPerMeter = 50.0f;
    const UnwrappedScene result = unwrapAndCheck(scene, settings);
    EXPECT_EQ(result.scene.meshes.size(), 2u);
    EXPECT_NEAR(texelAreaOf(result, 0), 2500.0, 5.0);
    EXPECT_NEAR(texelAreaOf(result, 1), 10000.0, 20.0);
    EXPECT_NEAR(texelAreaOf(result, 2), 2500.0, 5.0);
    EXPECT_EQ(result.scene.meshes[0].parts[0].lightmapUv, scene.meshes[0].parts[0].uv[1]);
}

TEST(UnwrapKeep, SaysWhyTexCoord1IsNotKept)
{
    const auto reasonFor = [](const std::function<void(MeshPart&)>& spoil, const char* expected) {
        Scene scene = shapes::scene(planeWithUv({0.1f, 0.1f}, {0.9f, 0.9f}));
        spoil(scene.meshes[0].parts[0]);
        const UnwrappedScene result = unwrapAndCheck(scene);
        ASSERT_EQ(result.meshes.size(), 1u);
        EXPECT_FALSE(result.meshes[0].kept);
        EXPECT_NE(result.meshes[0].reason.find(expected), std::string::npos) << result.meshes[0].reason;
        UnwrapSettings settings;
        settings.uvMode = UvMode::Keep;
        const Result<UnwrappedScene> kept = unwrap(scene, settings);
        ASSERT_FALSE(kept);
        EXPECT_EQ(kept.error().code, ErrorCode::FileInvalid);
        EXPECT_EQ(kept.error().object, "/meshes/0");
        EXPECT_NE(kept.error().message.find(expected), std::string::npos);
    };
    reasonFor([](MeshPart& part) { part.uv[1][3].x = 1.01f; }, "leaves [0,1]");
    reasonFor([](MeshPart& part) { part.uv[1][3].y = std::numeric_limits<float>::quiet_NaN(); }, "not finite");
    reasonFor([](MeshPart& part) { part.uv[1][6] = vec2(0.8f, 0.45f); }, "overlaps itself");
    reasonFor([](MeshPart& part) { std::fill(part.uv[1].begin(), part.uv[1].end(), vec2(0.5f)); }, "no area");
}

TEST(UnwrapKeep, ChartsThatComeTooCloseAreUnwrappedInAutoAndNamedInKeep)
{
    // Two planes in one mesh, 0.003 apart in uv: a texel and a half of 512.
    Scene scene = shapes::scene(
        shapes::together(planeWithUv({0.0f, 0.0f}, {0.4985f, 1.0f}), planeWithUv({0.5015f, 0.0f}, {1.0f, 1.0f})));
    for (vec3& p : scene.meshes[0].parts[1].positions) p.y = 1.0f;
    UnwrapSettings settings;
    settings.pageSize = 512;
    const UnwrappedScene automatic = unwrapAndCheck(scene, settings);
    EXPECT_FALSE(automatic.meshes[0].kept);
    EXPECT_NE(automatic.meshes[0].reason.find("closer than 2 texels"), std::string::npos) << automatic.meshes[0].reason;
    settings.uvMode = UvMode::Keep;
    const Result<UnwrappedScene> kept = unwrap(scene, settings);
    ASSERT_TRUE(kept);
    EXPECT_TRUE(kept->meshes[0].kept);
    EXPECT_EQ(kept->warnings.size(), 1u);
}

} // namespace
} // namespace halflight::unwrap_keep_test
