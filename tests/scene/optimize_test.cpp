// halflight optimize: smaller, and what the bake is stays.

#include "fixtures.h"
#include "validator.h"

#include "halflight/scene/optimize.h"
#include "halflight/scene/probe_cells.h"

#include <glm/gtc/packing.hpp>
#include <gmock/gmock.h>

namespace halflight::optimize_test {
namespace {

using namespace test;

class Optimize : public testing::Test {
protected:
    void SetUp() override
    {
        if (!canOptimizeGeometry() || !canOptimizeTextures())
            GTEST_SKIP() << "this build lacks meshoptimizer or libwebp";
    }

    /// A bake with made-up light of a scene with enough vertices and smooth pictures.
    BakedScene bake()
    {
        auto scene = readScene(std::filesystem::path(HALFLIGHT_SOURCE_DIR) / "assets/tests/sphere_on_floor.glb");
        EXPECT_TRUE(scene) << scene.error().text();
        BakedScene baked = pretendToBake(*scene, false);
        for (Object& object : baked.scene.objects) object.lightmap.page = std::min(object.lightmap.page, 0);
        baked.lightmaps = {Image<uint32_t>(256, 256)};
        baked.shadowmasks = {ImageRgba8(256, 256)};
        baked.lightmapDirections.clear();
        for (int y = 0; y < 256; ++y) {
            for (int x = 0; x < 256; ++x) {
                const vec3 light = vec3(0.2f + float(x) / 90.0f, 0.1f + float(y) / 200.0f, 0.7f);
                baked.lightmaps[0](x, y) = glm::packF3x9_E1x5(light);
                // Colour where alpha is 0: the fourth light is in shadow, the others are not.
                baked.shadowmasks[0](x, y) = u8vec4(x, y, (x + y) / 2, x < 128 ? 0 : 255);
            }
        }
        return baked;
    }

    TemporaryFolder folder;
};

TEST_F(Optimize, KeepsTheBake)
{
    const BakedScene before = bake();
    ASSERT_TRUE(writeBakedScene(folder / "baked.glb", before));
    OptimizeReport report;
    OptimizeOptions options;
    options.lightmapFormat = OptimizeOptions::LightmapFormat::Rgb9e5;
    const Status done = optimizeFile(folder / "baked.glb", folder / "small.glb", options, report);
    ASSERT_TRUE(done) << done.error().text();
    EXPECT_LT(report.file.after, report.file.before * 6 / 10);
    EXPECT_EQ(report.file.after, std::filesystem::file_size(folder / "small.glb"));

    const Result<BakedScene> read = readBakedScene(folder / "small.glb");
    ASSERT_TRUE(read) << read.error().text();
    EXPECT_THAT(read->scene.warnings, testing::IsEmpty()) << "nothing stale, nothing lost";
    EXPECT_EQ(read->shadowmasks.at(0).texels(), before.shadowmasks[0].texels()) << "also where alpha is 0";
    for (std::size_t i = 0; i < before.lightmaps[0].texelCount(); ++i) {
        const vec3 was = glm::unpackF3x9_E1x5(before.lightmaps[0].texels()[i]);
        const vec3 is = glm::unpackF3x9_E1x5(read->lightmaps.at(0).texels()[i]);
        ASSERT_LE(std::abs(is.x - was.x), std::max({was.x, was.y, was.z}) / 127.0f);
    }
    EXPECT_LT(report.lightmapErrorMost, 1.0 / 127.0);
    EXPECT_GT(report.lightmapErrorMost, 0.0);

    ASSERT_EQ(read->probes.probes.size(), before.probes.probes.size());
    for (std::size_t i = 0; i < before.probes.probes.size(); ++i) {
        const Probe& a = before.probes.probes[i];
        const Probe& b = read->probes.probes[i];
        EXPECT_EQ(a.position, b.position);
        EXPECT_LT(glm::distance(a.radiance[3], b.radiance[3]), 1.0e-3f);
        EXPECT_LT(glm::distance(a.occlusion.layers[0], b.occlusion.layers[0]), 1.0e-2f);
        EXPECT_EQ(b.occlusion[1], 1.0f) << "a channel without a light stays exactly 1";
    }
    EXPECT_EQ(read->probes.tetrahedra.size(), fileTetrahedra(probeCells(before.probes)).size());
}

TEST_F(Optimize, LightmapsByACurve)
{
    const BakedScene before = bake();
    ASSERT_TRUE(writeBakedScene(folder / "baked.glb", before));
    OptimizeReport report;
    const Status done = optimizeFile(folder / "baked.glb", folder / "small.glb", {}, report);
    ASSERT_TRUE(done) << done.error().text();
    EXPECT_LT(report.lightmaps.after, report.lightmaps.before);
    const Result<BakedScene> read = readBakedScene(folder / "small.glb");
    ASSERT_TRUE(read) << read.error().text();
    EXPECT_THAT(read->scene.warnings, testing::IsEmpty());
    double sum = 0.0;
    for (std::size_t i = 0; i < before.lightmaps[0].texelCount(); ++i) {
        const vec3 was = glm::unpackF3x9_E1x5(before.lightmaps[0].texels()[i]);
        const vec3 is = glm::unpackF3x9_E1x5(read->lightmaps.at(0).texels()[i]);
        const float brightest = std::max({was.x, was.y, was.z});
        const vec3 off = glm::abs(is - was);
        sum += double(std::max({off.x, off.y, off.z}) / brightest);
        ASSERT_LE(glm::distance(is, was), 0.04f * glm::length(was));
    }
    EXPECT_NEAR(sum / double(before.lightmaps[0].texelCount()), report.lightmapError, 1.0e-4);
    EXPECT_LT(report.lightmapError, 0.01);

    // Once more: nothing is lost twice.
    OptimizeReport again;
    ASSERT_TRUE(optimizeFile(folder / "small.glb", folder / "smaller.glb", {}, again));
    EXPECT_EQ(again.lightmaps.after, report.lightmaps.after);
    const Result<BakedScene> reread = readBakedScene(folder / "smaller.glb");
    ASSERT_TRUE(reread) << reread.error().text();
    EXPECT_EQ(reread->lightmaps[0].texels(), read->lightmaps[0].texels());
}

TEST_F(Optimize, MovesNoSurfaceAndNoTexel)
{
    const BakedScene before = bake();
    ASSERT_TRUE(writeBakedScene(folder / "baked.glb", before));
    OptimizeReport report;
    ASSERT_TRUE(optimizeFile(folder / "baked.glb", folder / "small.glb", {}, report));
    const Result<BakedScene> read = readBakedScene(folder / "small.glb");
    ASSERT_TRUE(read) << read.error().text();
    ASSERT_EQ(read->scene.objects.size(), before.scene.objects.size());
    for (std::size_t i = 0; i < before.scene.objects.size(); ++i) {
        const Object& x = before.scene.objects[i];
        const Object& y = read->scene.objects[i];
        EXPECT_EQ(x.worldFromObject, y.worldFromObject) << "nodes stay where they are";
        // Vertices have another order: each finds its place by position, normal and texel.
        const MeshPart& a = before.scene.meshes[std::size_t(x.mesh)].parts.at(0);
        const MeshPart& b = read->scene.meshes[std::size_t(y.mesh)].parts.at(0);
        ASSERT_EQ(a.indices.size(), b.indices.size());
        for (std::size_t v = 0; v < b.positions.size(); ++v) {
            float least = 1.0f;
            for (std::size_t w = 0; w < a.positions.size(); ++w) {
                float off = glm::distance(a.positions[w], b.positions[v]) * 10.0f;
                off += glm::distance(a.normals[w], b.normals[v]) * 0.1f;
                if (x.lightmap.page >= 0) {
                    off += glm::distance(x.lightmap.scale * a.lightmapUv[w] + x.lightmap.offset,
                                         y.lightmap.scale * b.lightmapUv[v] + y.lightmap.offset) *
                           100.0f;
                }
                least = std::min(least, off);
            }
            ASSERT_LT(least, 1.0e-2f) << x.name << " " << v;
        }
    }
}

TEST_F(Optimize, KeepsWhatItIsToldToKeep)
{
    ASSERT_TRUE(writeBakedScene(folder / "baked.glb", bake()));
    OptimizeReport report;
    OptimizeOptions options;
    options.geometry = false;
    options.textureQuality = 0;
    options.lightmapFormat = OptimizeOptions::LightmapFormat::Rgb9e5;
    options.lightmapBits = 9;
    ASSERT_TRUE(optimizeFile(folder / "baked.glb", folder / "same.glb", options, report));
    EXPECT_EQ(report.geometry.after, report.geometry.before);
    EXPECT_EQ(report.masks.after, report.masks.before);
    EXPECT_EQ(report.lightmapErrorMost, 0.0);
    const Json json = jsonOfGlb(folder / "same.glb");
    EXPECT_FALSE(json.contains("extensionsRequired"));
}

TEST_F(Optimize, PlainFilesToo)
{
    OptimizeReport report;
    const auto file = std::filesystem::path(HALFLIGHT_SOURCE_DIR) / "assets/tests/sphere_on_floor.glb";
    ASSERT_TRUE(optimizeFile(file, folder / "small.glb", {}, report));
    EXPECT_LT(report.file.after, report.file.before);
    const auto read = readScene(folder / "small.glb");
    ASSERT_TRUE(read) << read.error().text();
}

// The filter for unit vectors takes three or four numbers of each. Normals of one were read beyond their end.
TEST_F(Optimize, NormalsThatAreNoVectors)
{
    GltfBuilder file;
    file.triangle();
    file.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = file.floats({1, 2, 3}, "SCALAR", 1);
    const auto path = file.write(folder);
    OptimizeReport report;
    ASSERT_TRUE(optimizeFile(path, folder / "small.glb", {}, report));
    const Json json = jsonOfGlb(folder / "small.glb");
    const Json& normals = json["accessors"][json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"].get<int>()];
    EXPECT_EQ(normals["componentType"], 5126);
    EXPECT_EQ(json["bufferViews"][normals["bufferView"].get<int>()]["extensions"]["EXT_meshopt_compression"]["filter"],
              "EXPONENTIAL");
}

// Two indices are no triangle: of its vertices none is left to be compressed.
TEST_F(Optimize, PrimitivesWithoutATriangleStay)
{
    GltfBuilder file;
    file.triangle();
    file.json["meshes"][0]["primitives"].push_back(file.json["meshes"][0]["primitives"][0]);
    Json& line = file.json["meshes"][0]["primitives"][1];
    line = {{"attributes", {{"POSITION", file.floats({0, 0, 0, 1, 0, 0}, "VEC3", 3)}}},
            {"indices", file.accessor<uint16_t>({0, 1}, 5123, "SCALAR", 1)}};
    const auto path = file.write(folder);
    OptimizeReport report;
    ASSERT_TRUE(optimizeFile(path, folder / "small.glb", {}, report));
    EXPECT_TRUE(readScene(folder / "small.glb"));
    const Json json = jsonOfGlb(folder / "small.glb");
    const Json& stays = json["meshes"][0]["primitives"][1];
    EXPECT_EQ(json["accessors"][stays["attributes"]["POSITION"].get<std::size_t>()]["count"], 2);
    EXPECT_EQ(json["accessors"][stays["indices"].get<std::size_t>()]["count"], 2);
}

TEST_F(Optimize, RefusesVersion1)
{
    OptimizeReport report;
    const auto file = std::filesystem::path(HALFLIGHT_SOURCE_DIR) / "assets/tests/format_v1.glb";
    const Status done = optimizeFile(file, folder / "small.glb", {}, report);
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().code, ErrorCode::Unsupported);
    EXPECT_THAT(done.error().message, testing::HasSubstr("bake the scene again"));
}

TEST_F(Optimize, WritesWhatTheValidatorTakes)
{
    ASSERT_TRUE(writeBakedScene(folder / "baked.glb", bake()));
    OptimizeReport report;
    ASSERT_TRUE(optimizeFile(folder / "baked.glb", folder / "small.glb", {}, report));
    validate({folder / "small.glb"});
}

} // namespace
} // namespace halflight::optimize_test
