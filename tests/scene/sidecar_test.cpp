// The sidecar binds a bake back to a file that lost it: by node name, and by the way through the hierarchy where names
// do not tell.

#include "fixtures.h"

#include "halflight/scene/sidecar.h"

#include <algorithm>
#include <gmock/gmock.h>
#include <map>

namespace halflight::sidecar_test {
namespace {

using namespace test;
using testing::ElementsAre;
using testing::HasSubstr;

std::vector<ImageRgb32f> floats()
{
    std::vector<ImageRgb32f> pages;
    for (const float first : {0.25f, 1.0f}) {
        ImageRgb32f page(8, 8);
        for (std::size_t i = 0; i < page.texelCount(); ++i) page.texels()[i] = vec3(first + float(i), 0.5f, 70000.0f);
        pages.push_back(std::move(page));
    }
    return pages;
}

class Sidecar : public testing::Test {
protected:
    void write(const BakedScene& baked, std::optional<LightmapFormat> format = std::nullopt)
    {
        std::filesystem::create_directories(folder / "beside");
        ASSERT_TRUE(writeBakedScene(folder / "baked.glb", baked));
        const std::vector<ImageRgb32f> pages = floats();
        SidecarOptions options;
        options.format = format;
        options.write.irradiance = pages;
        const Status done = writeSidecar(folder / "beside", folder / "baked.glb", baked, options, warnings);
        ASSERT_TRUE(done) << done.error().text();
        std::ifstream stream(folder / "beside/bake.json");
        sidecar = Json::parse(stream);
        document = jsonOfGlb(folder / "baked.glb");
    }
    /// The node that a binding means, in a document without extensions.
    static std::size_t find(const Json& plain, const Json& binding)
    {
        std::vector<std::size_t> found;
        for (std::size_t i = 0; i < plain["nodes"].size(); ++i) {
            if (plain["nodes"][i].value("name", "") == binding["node"].get<std::string>()) found.push_back(i);
        }
        if (found.size() == 1 && binding["node"] != "") return found[0];
        Json list = plain["scenes"][0]["nodes"];
        std::size_t node = 0;
        for (const Json& place : binding["path"]) {
            node = list.at(place.get<std::size_t>()).get<std::size_t>();
            list = plain["nodes"][node].value("children", Json::array());
        }
        return node;
    }

    const TemporaryFolder folder;
    std::vector<std::string> warnings;
    Json sidecar;
    Json document;
};

TEST_F(Sidecar, BindsEachObjectAndLightBack)
{
    BakedScene baked = pretendToBake(engineScene());
    ASSERT_NO_FATAL_FAILURE(write(baked));
    EXPECT_THAT(warnings, ElementsAre());
    // A tool drops the extensions and turns the order of nodes round.
    Json plain = document;
    const std::size_t count = plain["nodes"].size();
    std::reverse(plain["nodes"].begin(), plain["nodes"].end());
    for (Json& index : plain["scenes"][0]["nodes"]) index = count - 1 - index.get<std::size_t>();
    for (Json& node : plain["nodes"]) node.erase("extensions");
    ASSERT_EQ(sidecar["objects"].size(), 3u);
    ASSERT_EQ(sidecar["lights"].size(), 5u);
    for (const auto& [list, extension] : {std::pair("objects", "HALFLIGHT_node"), {"lights", "HALFLIGHT_light"}}) {
        for (Json binding : sidecar[list]) {
            const std::size_t node = count - 1 - find(plain, binding);
            Json record = document["nodes"][node]["extensions"][extension];
            record.erase("atBake");
            if (record.contains("baking")) record["baking"].erase("atBake");
            binding.erase("node");
            binding.erase("path");
            EXPECT_EQ(binding, record);
        }
    }
}

TEST_F(Sidecar, EqualNamesAreToldByTheirPlaceAndNamedInAWarning)
{
    Scene scene = engineScene();
    for (Object& object : scene.objects) object.name = "quad";
    BakedScene baked = pretendToBake(scene);
    ASSERT_NO_FATAL_FAILURE(write(baked));
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_THAT(warnings[0], HasSubstr("3 objects have no name of their own"));
    EXPECT_THAT(warnings[0], HasSubstr("'quad'"));
    std::set<std::size_t> nodes;
    for (const Json& binding : sidecar["objects"]) {
        const std::size_t node = find(document, binding);
        nodes.insert(node);
        EXPECT_EQ(binding.value("lightmap", Json()),
                  document["nodes"][node]["extensions"]["HALFLIGHT_node"].value("lightmap", Json()));
    }
    EXPECT_EQ(nodes.size(), 3u);
}

TEST_F(Sidecar, TheSkysPictureIsAFile)
{
    BakedScene baked = pretendToBake(engineScene());
    baked.scene.sky.setPicture(std::make_shared<const ImageRgb32f>(8, 4, vec3(1, 2, 3)), 0.5f);
    ASSERT_NO_FATAL_FAILURE(write(baked));
    EXPECT_EQ(sidecar["sky"]["picture"]["rotation"], 0.5f);
    const auto picture = readExr(folder / "beside" / sidecar["sky"]["picture"]["file"].get<std::string>());
    ASSERT_TRUE(picture) << picture.error().text();
    ASSERT_EQ(picture->size(), ivec2(8, 4));
    EXPECT_EQ((*picture)(5, 2), vec4(1, 2, 3, 1));
}

TEST_F(Sidecar, PicturesAreTheBakes)
{
    const BakedScene baked = pretendToBake(engineScene());
    ASSERT_NO_FATAL_FAILURE(write(baked));
    EXPECT_EQ(sidecar["lightmaps"]["format"], "exr");
    EXPECT_EQ(sidecar["lightmaps"]["unitLux"], 1);
    for (std::size_t p = 0; p < 2; ++p) {
        const auto file = [&](const Json& name) { return folder / "beside" / name.get<std::string>(); };
        const auto light = readExr(file(sidecar["lightmaps"]["pages"][p]));
        ASSERT_TRUE(light) << light.error().text();
        const ImageRgb32f truth = floats()[p];
        for (std::size_t i = 0; i < truth.texelCount(); ++i) EXPECT_EQ(vec3(light->texels()[i]), truth.texels()[i]);
        const auto mask = readPng(file(sidecar["shadowmasks"][p]));
        ASSERT_TRUE(mask) << mask.error().text();
        EXPECT_EQ(mask->texels(), baked.shadowmasks[p].texels());
        const auto directions = readPng(file(sidecar["lightmapDirections"][p]));
        ASSERT_TRUE(directions) << directions.error().text();
        EXPECT_EQ(directions->texels(), baked.lightmapDirections[p].texels());
    }
    const auto& probes = baked.probes.probes;
    ASSERT_EQ(sidecar["probes"]["positions"].size(), probes.size());
    for (std::size_t i = 0; i < probes.size(); ++i) {
        EXPECT_EQ(sidecar["probes"]["radiance"][i].size(), 27u);
        EXPECT_FLOAT_EQ(sidecar["probes"]["radiance"][i][4].get<float>(), probes[i].radiance[1].y);
        EXPECT_FLOAT_EQ(sidecar["probes"]["occlusion"][i][2].get<float>(), probes[i].occlusion[2]);
        EXPECT_EQ(sidecar["probes"]["valid"][i], probes[i].valid);
    }
}

TEST_F(Sidecar, AGridOfProbesSaysWhereEachIs)
{
    BakedScene baked = pretendToBake(engineScene());
    baked.scene.originMeters = {1000.0, 0.0, -50.0};
    ProbeSet& set = baked.probes;
    set = {vec3(1, 2, 3), vec3(0.5f, 1, 2), ivec3(2, 3, 2), {}, {}};
    for (int i = 0; i < 12; ++i) {
        Probe probe;
        probe.position = set.origin + set.spacingMeters * vec3(i % 2, i / 2 % 3, i / 6);
        set.probes.push_back(probe);
    }
    ASSERT_NO_FATAL_FAILURE(write(baked));
    const Json& probes = sidecar["probes"];
    const auto size = probes["grid"]["size"].get<std::vector<std::size_t>>();
    ASSERT_EQ(size, (std::vector<std::size_t>{2, 3, 2}));
    for (std::size_t z = 0; z < size[2]; ++z) {
        for (std::size_t y = 0; y < size[1]; ++y) {
            for (std::size_t x = 0; x < size[0]; ++x) {
                const Json& position = probes["positions"][(z * size[1] + y) * size[0] + x];
                const std::size_t at[] = {x, y, z};
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    const double expected = probes["grid"]["origin"][axis].get<double>() +
                                            probes["grid"]["spacing"][axis].get<double>() * double(at[axis]);
                    EXPECT_NEAR(position[axis].get<double>(), expected, 1.0e-6);
                }
            }
        }
    }
}

TEST_F(Sidecar, LightmapsMayHaveTheFormatOfTheFile)
{
    ASSERT_NO_FATAL_FAILURE(write(pretendToBake(engineScene()), LightmapFormat::Half));
    EXPECT_EQ(sidecar["lightmaps"]["format"], "half");
    EXPECT_EQ(sidecar["lightmaps"]["unitLux"], 4.0);
    EXPECT_THAT(sidecar["lightmaps"]["pages"].get<std::vector<std::string>>(),
                ElementsAre("lightmap_0.ktx2", "lightmap_1.ktx2"));
}

TEST_F(Sidecar, InstancesHaveTheirRectangles)
{
    GltfBuilder builder;
    builder.triangle();
    builder.json["extensionsUsed"] = {"EXT_mesh_gpu_instancing"};
    builder.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
        {"TRANSLATION", builder.floats({0, 0, 0, 5, 0, 0}, "VEC3", 3)}};
    const auto scene = readScene(builder.write(folder));
    ASSERT_TRUE(scene) << scene.error().text();
    const BakedScene baked = pretendToBake(*scene, false);
    ASSERT_NO_FATAL_FAILURE(write(baked));
    ASSERT_EQ(sidecar["objects"].size(), 1u);
    const Json& instances = sidecar["objects"][0]["lightmap"]["instances"];
    ASSERT_EQ(instances.size(), 2u);
    const auto read = readBakedScene(folder / "baked.glb");
    ASSERT_TRUE(read) << read.error().text();
    for (std::size_t i = 0; i < 2; ++i) {
        const LightmapBinding& place = read->scene.objects[i].lightmap;
        EXPECT_EQ(instances[i]["page"], place.page);
        EXPECT_FLOAT_EQ(instances[i]["scale"][0].get<float>(), place.scale.x);
        EXPECT_FLOAT_EQ(instances[i]["offset"][1].get<float>(), place.offset.y);
    }
}

} // namespace
} // namespace halflight::sidecar_test
