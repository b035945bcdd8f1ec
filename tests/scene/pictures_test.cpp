// The bake's pictures are textures of the document, and its probes have their tetrahedra with them.

#include "fixtures.h"

#include "halflight/scene/optimize.h"
#include "halflight/scene/probe_cells.h"

#include <functional>
#include <gmock/gmock.h>

namespace halflight::pictures_test {
namespace {

using namespace test;
using testing::HasSubstr;

const Json& rootOf(const Json& document)
{
    return document["extensions"]["HALFLIGHT_mixed_lighting"];
}

/// Probes at the corners and in the middle of a box that is no grid.
BakedScene withLooseProbes()
{
    BakedScene baked = pretendToBake(engineScene(), false);
    ProbeSet& set = baked.probes;
    set.size = ivec3(0);
    for (std::size_t i = 0; i < set.probes.size(); ++i) {
        Probe& probe = set.probes[i];
        probe.position = vec3(float(i & 1), float(i >> 1 & 1), float(i >> 2 & 1)) * vec3(3.0f, 2.0f, 4.0f);
        if (i >= 8) probe.position = vec3(0.7f + 0.3f * float(i - 8), 1.1f, 1.9f);
    }
    return baked;
}

/// Reads the file after a change of its JSON.
Result<BakedScene> readChanged(const TemporaryFolder& folder, const std::filesystem::path& file,
                               const std::function<void(Json&, std::vector<char>&)>& change)
{
    std::vector<char> binary;
    Json json = jsonOfGlb(file, &binary);
    change(json, binary);
    json["buffers"][0]["uri"] = "binary.bin";
    writeText(folder / "binary.bin", std::string(binary.begin(), binary.end()));
    writeText(folder / "changed.gltf", json.dump());
    return readBakedScene(folder / "changed.gltf");
}

TEST(Pictures, AreTexturesWithASourceThatNoMaterialNames)
{
    const TemporaryFolder folder;
    ASSERT_TRUE(writeBakedScene(folder / "baked.glb", pretendToBake(engineScene(), false)));
    const Json json = jsonOfGlb(folder / "baked.glb");
    for (const char* list : {"lightmaps", "lightmapDirections", "shadowmasks"}) {
        ASSERT_EQ(rootOf(json)[list].size(), 2u) << list;
        for (const Json& reference : rootOf(json)[list]) {
            const Json& texture = json["textures"].at(reference["index"].get<std::size_t>());
            const Json& source = json["images"].at(texture["source"].get<std::size_t>());
            EXPECT_EQ(source["mimeType"], "image/png");
            EXPECT_EQ(json["samplers"].at(texture["sampler"].get<std::size_t>())["wrapS"], 33071);
            if (std::string(list) != "lightmaps") continue;
            const Json& extension = texture["extensions"]["HALFLIGHT_texture_ktx2"];
            EXPECT_EQ(json["images"].at(extension["source"].get<std::size_t>())["mimeType"], "image/ktx2");
        }
    }
    EXPECT_EQ(json["images"].size(), 1u + 3u * 2u + 1u + 1u) << "the scene's, the bake's, one placeholder";
}

TEST(Pictures, AnotherBakeTakesThePlacesOfTheLastOne)
{
    const TemporaryFolder folder;
    ASSERT_TRUE(writeBakedScene(folder / "first.glb", pretendToBake(engineScene(), false)));
    const Json first = jsonOfGlb(folder / "first.glb");
    const auto scene = readScene(folder / "first.glb");
    ASSERT_TRUE(scene) << scene.error().text();
    BakedScene again = pretendToBake(*scene, false);
    ASSERT_TRUE(writeBakedScene(folder / "again.glb", again));
    const Json second = jsonOfGlb(folder / "again.glb");
    for (const char* array : {"textures", "images", "samplers", "bufferViews", "accessors"})
        EXPECT_EQ(second[array].size(), first[array].size()) << array;

    // Fewer pages: no picture of the earlier bake is left.
    for (Object& object : again.scene.objects) object.lightmap.page = std::min(object.lightmap.page, 0);
    again.lightmaps.pop_back();
    again.shadowmasks.pop_back();
    again.lightmapDirections.clear();
    ASSERT_TRUE(writeBakedScene(folder / "fewer.glb", again));
    const Json third = jsonOfGlb(folder / "fewer.glb");
    EXPECT_EQ(third["textures"].size(), 1u + 2u + 1u);
    EXPECT_EQ(third["images"].size(), 1u + 2u + 1u + 1u);
    const auto read = readBakedScene(folder / "fewer.glb");
    ASSERT_TRUE(read) << read.error().text();
    EXPECT_EQ(read->lightmaps.at(0).texels(), again.lightmaps[0].texels());
    EXPECT_EQ(read->shadowmasks.at(0).texels(), again.shadowmasks[0].texels());
    EXPECT_EQ(read->scene.textures.size(), 1u);
}

TEST(Pictures, MissingOnesAreNamed)
{
    const TemporaryFolder folder;
    ASSERT_TRUE(writeBakedScene(folder / "baked.glb", pretendToBake(engineScene(), false)));
    const auto errorAfter = [&](const std::function<void(Json&)>& change) {
        const auto read =
            readChanged(folder, folder / "baked.glb", [&](Json& json, std::vector<char>&) { change(json); });
        return read ? std::string("read") : read.error().text();
    };
    const auto masks = [](Json& json) -> Json& {
        return json["extensions"]["HALFLIGHT_mixed_lighting"]["shadowmasks"];
    };
    EXPECT_THAT(errorAfter([&](Json& json) { masks(json)[1]["index"] = 99; }), HasSubstr("shadowmasks/1"));
    EXPECT_THAT(errorAfter([&](Json& json) { masks(json)[1]["index"] = -1; }), HasSubstr("shadowmasks/1/index"));
    EXPECT_THAT(
        errorAfter([&](Json& json) { json["textures"][masks(json)[0]["index"].get<std::size_t>()].erase("source"); }),
        HasSubstr("texture without an image"));
}

TEST(ProbeTetrahedra, AreThoseOfTheFile)
{
    const TemporaryFolder folder;
    const BakedScene baked = withLooseProbes();
    const std::vector<Tetrahedron> made = fileTetrahedra(probeCells(baked.probes));
    ASSERT_GT(made.size(), 10u);
    ASSERT_TRUE(writeBakedScene(folder / "baked.glb", baked));
    const auto read = readBakedScene(folder / "baked.glb");
    ASSERT_TRUE(read) << read.error().text();
    ASSERT_EQ(read->probes.tetrahedra.size(), made.size());
    for (std::size_t i = 0; i < made.size(); ++i) {
        EXPECT_EQ(read->probes.tetrahedra[i].vertex, made[i].vertex);
        EXPECT_EQ(read->probes.tetrahedra[i].neighbor, made[i].neighbor);
    }
    const ProbeCells before = probeCells(baked.probes);
    const ProbeCells after = probeCells(read->probes);
    ASSERT_EQ(after.cells.size(), before.cells.size());
    EXPECT_EQ(after.vertices, before.vertices);

    // They are used as they are: with one of them only, there is one.
    BakedScene one = *read;
    one.probes.tetrahedra = {{made[0].vertex, {kOutside, kOutside, kOutside, kOutside}}};
    EXPECT_EQ(probeCells(one.probes).cells.size(), 1u);
    // One that an edit of positions turned inside out is not: they are made anew.
    std::swap(one.probes.tetrahedra[0].vertex[0], one.probes.tetrahedra[0].vertex[1]);
    EXPECT_EQ(probeCells(one.probes).cells.size(), made.size());
}

/// Two of the probes have maps.
BakedScene withSight()
{
    BakedScene baked = withLooseProbes();
    ProbeSight& sight = baked.probes.sight;
    sight.size = 3;
    sight.rangeMeters.assign(baked.probes.probes.size(), 0.0f);
    sight.rangeMeters[2] = 1.5f;
    sight.rangeMeters[7] = 2.5f;
    for (uint16_t i = 0; i < 18; ++i) sight.corners.push_back({uint16_t(1000 * i + 3), uint16_t(65535 - 7 * i)});
    return baked;
}

TEST(ProbeSightS14, FilesKeepItAlsoWhenOptimized)
{
    const TemporaryFolder folder;
    const BakedScene baked = withSight();
    ASSERT_TRUE(writeBakedScene(folder / "baked.glb", baked));
    OptimizeReport report;
    ASSERT_TRUE(optimizeFile(folder / "baked.glb", folder / "small.glb", {}, report));
    for (const char* file : {"baked.glb", "small.glb"}) {
        const auto read = readBakedScene(folder / file);
        ASSERT_TRUE(read) << read.error().text();
        const ProbeSight& sight = read->probes.sight;
        EXPECT_EQ(sight.size, 3);
        EXPECT_EQ(sight.rangeMeters, baked.probes.sight.rangeMeters);
        ASSERT_EQ(sight.corners.size(), 18u);
        for (std::size_t i = 0; i < 18; ++i) {
            EXPECT_EQ(sight.corners[i].distance, baked.probes.sight.corners[i].distance) << i;
            EXPECT_EQ(sight.corners[i].deviation, baked.probes.sight.corners[i].deviation) << i;
        }
    }
}

TEST(ProbeSightS14, WrongMapsAreRefused)
{
    const TemporaryFolder folder;
    ASSERT_TRUE(writeBakedScene(folder / "baked.glb", withSight()));
    const auto errorAfter = [&](const std::function<void(Json&, Json&)>& change) {
        const auto read = readChanged(folder, folder / "baked.glb", [&](Json& json, std::vector<char>&) {
            Json& probes = json["extensions"]["HALFLIGHT_mixed_lighting"]["probes"];
            change(probes, json["accessors"][probes["sight"].get<std::size_t>()]);
        });
        return read ? std::string("read") : read.error().text();
    };
    EXPECT_EQ(errorAfter([](Json&, Json&) {}), "read");
    EXPECT_THAT(errorAfter([](Json&, Json& accessor) { accessor["count"] = 17; }),
                HasSubstr("sight does not hold a square map"));
    EXPECT_THAT(errorAfter([](Json&, Json& accessor) { accessor["type"] = "SCALAR"; }),
                HasSubstr("not VEC2 of unsigned short"));
    EXPECT_THAT(errorAfter([](Json& probes, Json&) { probes["sight"] = 9999; }),
                HasSubstr("sight refers to an accessor"));
    EXPECT_THAT(errorAfter([](Json& probes, Json&) { probes["sightRanges"] = probes["sight"]; }),
                HasSubstr("sightRanges"));
    // Without maps, as in files of earlier versions, the probes are read and see through walls.
    EXPECT_EQ(errorAfter([](Json& probes, Json&) {
                  probes.erase("sight");
                  probes.erase("sightRanges");
              }),
              "read");
}

TEST(ProbeTetrahedra, OfAPlaneAreNotWritten)
{
    const TemporaryFolder folder;
    BakedScene baked = withLooseProbes();
    for (Probe& probe : baked.probes.probes) probe.position.y = 1.0f;
    ASSERT_TRUE(writeBakedScene(folder / "baked.glb", baked));
    EXPECT_FALSE(rootOf(jsonOfGlb(folder / "baked.glb"))["probes"].contains("tetrahedra"));
    ASSERT_TRUE(readBakedScene(folder / "baked.glb"));
}

TEST(ProbeTetrahedra, WrongOnesAreRefused)
{
    const TemporaryFolder folder;
    ASSERT_TRUE(writeBakedScene(folder / "baked.glb", withLooseProbes()));
    const auto errorWith = [&](const char* key, std::size_t place, uint32_t value) {
        const auto read = readChanged(folder, folder / "baked.glb", [&](Json& json, std::vector<char>& binary) {
            const auto accessor = rootOf(json)["probes"][key].get<std::size_t>();
            const Json& view = json["bufferViews"][json["accessors"][accessor]["bufferView"].get<std::size_t>()];
            std::memcpy(&binary[view["byteOffset"].get<std::size_t>() + 4 * place], &value, 4);
        });
        return read ? std::string("read") : read.error().text();
    };
    EXPECT_THAT(errorWith("tetrahedra", 6, 12), HasSubstr("tetrahedron 1 has a vertex that is no valid probe"));
    EXPECT_THAT(errorWith("tetrahedra", 0, 5), HasSubstr("no valid probe")) << "probe 5 is inside geometry";
    EXPECT_THAT(errorWith("neighbors", 2, 100000), HasSubstr("tetrahedron 0 has a neighbour that is not beside it"));
    EXPECT_THAT(errorWith("neighbors", 2, 0), HasSubstr("not beside it"));
}

} // namespace
} // namespace halflight::pictures_test
