// S33. Light groups: authored names, who is a member, white light, and materials that several groups share.

#include "fixtures.h"

#include "halflight/scene/gltf.h"
#include "halflight/scene/light_groups.h"

#include <gmock/gmock.h>

#include <array>

namespace halflight::light_groups_test {
namespace {

using namespace test;
using testing::Contains;
using testing::HasSubstr;

/// Three nodes of one mesh, which emits: in two rooms with a group each, and in neither. A light in the first room.
GltfBuilder rooms()
{
    GltfBuilder file;
    file.triangle();
    file.json["materials"] = {{{"name", "neon"}, {"emissiveFactor", {1, 0.5, 0}}}, {{"name", "wall"}}};
    file.json["meshes"][0]["primitives"][0]["material"] = 0;
    file.json["extensionsUsed"] = {"KHR_lights_punctual"};
    file.json["extensions"]["KHR_lights_punctual"]["lights"] = {
        {{"type", "point"}, {"name", "lamp"}, {"color", {1, 0, 0}}, {"intensity", 40}}};
    file.json["scenes"][0]["nodes"] = {0, 1, 4};
    file.json["nodes"] = {{{"name", "first"}, {"children", {2, 3}}, {"extras", {{"halflight_group", "room 1"}}}},
                          {{"name", "second"}, {"mesh", 0}, {"extras", {{"halflight_group", "room 2"}}}},
                          {{"name", "sign"}, {"mesh", 0}},
                          {{"name", "lamp"}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}},
                          {{"name", "outside"}, {"mesh", 0}}};
    return file;
}

std::string groupOf(const Scene& scene, const std::string& object)
{
    for (const Object& o : scene.objects)
        if (o.name == object) return materialOf(scene, scene.meshes[std::size_t(o.mesh)].parts[0]).group;
    return "no such object";
}

TEST(LightGroupsS33, NodesGiveTheirGroupToLightsAndEmissionBelow)
{
    const TemporaryFolder folder;
    const auto scene = readScene(rooms().write(folder));
    ASSERT_TRUE(scene) << scene.error().text();
    EXPECT_EQ(scene->lights.at(0).group, "room 1");
    EXPECT_EQ(groupOf(*scene, "sign"), "room 1");
    EXPECT_EQ(groupOf(*scene, "second"), "room 2");
    EXPECT_EQ(groupOf(*scene, "outside"), "");
    EXPECT_EQ(scene->materials.size(), 4u) << "neon of two groups and of none, wall";
    EXPECT_EQ(scene->meshes.size(), 3u);
}

TEST(LightGroupsS33, ASettingsFileIsStronger)
{
    const TemporaryFolder folder;
    writeText(folder / "s.toml", "[[light]]\npattern = \"lamp\"\ngroup = \"lamps\"\n[sky]\ncolor = 2\ngroup = \"day\"\n"
                                 "[[node]]\npattern = \"second\"\ngroup = \"room 1\"\n");
    ReadOptions options;
    options.settingsFile = folder / "s.toml";
    const auto scene = readScene(rooms().write(folder), options);
    ASSERT_TRUE(scene) << scene.error().text();
    EXPECT_EQ(scene->lights.at(0).group, "lamps");
    EXPECT_EQ(scene->sky.group, "day");
    EXPECT_EQ(groupOf(*scene, "second"), "room 1");
}

TEST(SkyChangesS34, TheSceneOrASettingsFileSaysSo)
{
    const TemporaryFolder folder;
    GltfBuilder file = rooms();
    file.json["scenes"][0]["extras"] = {{"halflight_sky", 2}, {"halflight_sky_changes", 1}};
    const auto scene = readScene(file.write(folder));
    ASSERT_TRUE(scene) << scene.error().text();
    EXPECT_TRUE(scene->sky.changes);
    writeText(folder / "s.toml", "[sky]\nchanges = false\n");
    ReadOptions options;
    options.settingsFile = folder / "s.toml";
    EXPECT_FALSE(readScene(file.write(folder), options)->sky.changes);
    file.json["scenes"][0]["extras"]["halflight_sky_changes"] = "often";
    EXPECT_THAT(readScene(file.write(folder)).error().text(), HasSubstr("halflight_sky_changes must be"));
}

TEST(SkyChangesS34, AGradientIsThreeGroupsAndAPictureIsOne)
{
    Scene scene;
    scene.sky = Sky{vec3(2, 4, 8), vec3(0), vec3(1)};
    scene.sky.changes = true;
    scene.sky.group = "day";
    const Scene before = scene;
    auto grouping = groupLights(scene, GroupChoice::Authored);
    ASSERT_TRUE(grouping);
    ASSERT_EQ(grouping->groups.size(), 3u);
    EXPECT_THAT(scene.warnings, Contains(HasSubstr("no member of the light group \"day\"")));
    for (std::size_t part = 0; part < 3; ++part) EXPECT_EQ(grouping->groups[part].name, kSkyParts[part]);
    EXPECT_EQ(grouping->ofSky, (std::array{0, 1, 2}));
    EXPECT_EQ(grouping->groups[0].weight / grouping->groups[0].finished, vec3(2, 4, 8)) << "its radiance, cd/m2";
    EXPECT_EQ(grouping->groups[1].weight, vec3(0)) << "black";
    grouping->exchange(scene);
    EXPECT_EQ(scene.sky.zenith, vec3(8)) << "as bright as it is";
    EXPECT_EQ(scene.sky.horizon, vec3(1)) << "a black part shines in its bake";
    grouping->exchange(scene);
    EXPECT_EQ(scene.sky.zenith, before.sky.zenith);

    EXPECT_TRUE(groupLights(scene, GroupChoice::Off)->groups.empty());
    EXPECT_EQ(groupLights(scene, GroupChoice::Each)->groups.size(), 3u);
    scene.sky.setPicture(std::make_shared<const ImageRgb32f>(8, 4), 0.0f);
    grouping = groupLights(scene, GroupChoice::Authored);
    ASSERT_EQ(grouping->groups.size(), 1u);
    EXPECT_EQ(grouping->groups[0].name, kSkyPictureGroup);
    EXPECT_EQ(grouping->groups[0].weight, vec3(1));
}

TEST(LightGroupsS33, NamesOfTheSkysPartsAreKept)
{
    for (const Json& name : {Json("sky.zenith"), Json(""), Json(3), Json(std::string(65, 'a')), Json("a\nb")}) {
        const TemporaryFolder folder;
        GltfBuilder file = rooms();
        file.json["nodes"][0]["extras"]["halflight_group"] = name;
        const auto scene = readScene(file.write(folder));
        ASSERT_FALSE(scene) << name;
        EXPECT_THAT(scene.error().text(), HasSubstr("halflight_group must be a name of 1 to 64 characters"));
    }
}

/// A lamp of a colour and an intensity, in a group.
Light lampIn(const char* group, vec3 color, float intensity)
{
    Light light;
    light.name = "lamp";
    light.group = group;
    light.color = color;
    light.intensity = intensity;
    return light;
}

TEST(LightGroupsS33, AGroupIsBakedInWhiteAndTheWeightIsItsColour)
{
    Scene scene;
    scene.lights = {lampIn("lamps", {0.5f, 0.2f, 0}, 10), lampIn("lamps", {0.25f, 0.4f, 0}, 30),
                    lampIn("", {1, 0, 0}, 7), lampIn("off", {1, 0, 0}, 0), lampIn("far", {1, 0, 0}, 5)};
    scene.lights[4].mode = LightMode::Realtime;
    scene.sky.zenith = vec3(0, 0, 8);
    scene.sky.horizon = vec3(0, 2, 4);
    scene.sky.group = "day";
    const Scene before = scene;
    auto grouping = groupLights(scene, GroupChoice::Authored);
    ASSERT_TRUE(grouping);
    ASSERT_EQ(grouping->groups.size(), 3u) << "realtime lights have no group";
    EXPECT_THAT(scene.warnings, Contains(HasSubstr("light lamp is realtime")));
    EXPECT_EQ(grouping->groups[0].weight, vec3(0.5f, 0.4f, 0));
    EXPECT_EQ(grouping->groups[1].weight, vec3(0)) << "a lamp that is off";
    EXPECT_EQ(grouping->ofLight, (std::vector<int>{0, 0, -1, 1, -1}));
    EXPECT_EQ(grouping->ofSky, (std::array{2, 2, 2}));
    grouping->exchange(scene);
    EXPECT_EQ(scene.lights[0].color, vec3(1, 0.5f, 1)) << "1 where the group is black";
    EXPECT_EQ(scene.lights[1].color, vec3(0.5f, 1, 1));
    EXPECT_EQ(scene.lights[1].intensity, 30.0f);
    EXPECT_EQ(scene.lights[2].color, vec3(1, 0, 0)) << "the rest keeps its colours";
    EXPECT_EQ(scene.lights[3].color * scene.lights[3].intensity, vec3(1)) << "a lamp that is off shines in its bake";
    EXPECT_EQ(scene.sky.horizon * grouping->groups[2].weight, vec3(0, 2, 4));
    EXPECT_EQ(scene.sky.horizon.x, 8.0f) << "the sky's blue and green may become white";
    grouping->exchange(scene);
    for (std::size_t i = 0; i < scene.lights.size(); ++i) {
        EXPECT_EQ(scene.lights[i].color, before.lights[i].color);
        EXPECT_EQ(scene.lights[i].intensity, before.lights[i].intensity);
    }
    EXPECT_EQ(scene.sky.zenith, before.sky.zenith);
}

TEST(LightGroupsS33, EachSourceOrNoneIsAGroup)
{
    const TemporaryFolder folder;
    auto scene = readScene(rooms().write(folder));
    ASSERT_TRUE(scene);
    const auto each = groupLights(*scene, GroupChoice::Each);
    ASSERT_TRUE(each);
    std::vector<std::string> names;
    for (const LightGroup& group : each->groups) names.push_back(group.name);
    EXPECT_EQ(names, (std::vector<std::string>{"lamp", "neon", "neon 2", "neon 3"}));
    const auto off = groupLights(*scene, GroupChoice::Off);
    ASSERT_TRUE(off);
    EXPECT_TRUE(off->groups.empty());
    scene->lights.assign(17, lampIn("", vec3(1), 1));
    const auto tooMany = groupLights(*scene, GroupChoice::Each);
    ASSERT_FALSE(tooMany);
    EXPECT_THAT(tooMany.error().text(), HasSubstr("has 20 light groups, and a bake has at most 16"));
}

// What a file of version 3 says of its groups fits together, or one sentence names what does not.
TEST(LightGroupsS33, FilesWithBadGroupsAreRefused)
{
    using Json = decltype(GltfBuilder().json);
    const auto refusal = [](const Json& groups, int version = 3) {
        const TemporaryFolder folder;
        GltfBuilder file;
        file.triangle();
        file.json["extensionsUsed"] = {"HALFLIGHT_mixed_lighting"};
        file.json["extensions"]["HALFLIGHT_mixed_lighting"] = {
            {"version", version}, {"mode", "shadowmask"}, {"groups", groups}};
        const auto baked = readBakedScene(file.write(folder));
        return baked ? std::string("read") : baked.error().text();
    };
    const Json good = {{"name", "lamps"}, {"weight", {1, 0.5, 0}}};
    const auto with = [&](const char* key, const Json& value) {
        Json group = good;
        group[key] = value;
        return Json::array({group});
    };
    EXPECT_EQ(refusal(Json::array({good})), "read");
    EXPECT_THAT(refusal(Json::array({good}), 2), HasSubstr("version has no groups"));
    EXPECT_THAT(refusal(5), HasSubstr("groups: is 5, not an array"));
    EXPECT_THAT(refusal(Json::array({good, good})), HasSubstr("no name of its own"));
    EXPECT_THAT(refusal(with("name", "")), HasSubstr("no name of its own"));
    EXPECT_THAT(refusal(with("weight", {1, 0})), HasSubstr("weight"));
    EXPECT_THAT(refusal(with("weight", {1, 0, -1})), HasSubstr("weight"));
    EXPECT_THAT(refusal(with("lightmaps", Json::array({Json::object()}))), HasSubstr("lightmaps"));
    EXPECT_THAT(refusal(with("lightmapUnitLux", 0)), HasSubstr("lightmapUnitLux"));
    Json many = Json::array();
    for (int i = 0; i < 17; ++i) many.push_back({{"name", std::to_string(i)}, {"weight", {1, 1, 1}}});
    EXPECT_THAT(refusal(many), HasSubstr("16"));
    for (const std::string& sentence : {refusal(5), refusal(many)})
        EXPECT_THAT(sentence, testing::Not(HasSubstr("\n")));
}

} // namespace
} // namespace halflight::light_groups_test
