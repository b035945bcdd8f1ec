// Area lights in files: EXT_lights_area, extras, settings files, and baked files that give them back.

#include "fixtures.h"
#include "scene/settings/settings.h"

#include <gmock/gmock.h>

namespace halflight::area_lights_test {
namespace {

using namespace test;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

GltfBuilder fileWith(const Json& light, const Json& node = Json::object())
{
    GltfBuilder file;
    file.triangle();
    file.json["extensionsUsed"] = {"EXT_lights_area"};
    file.json["extensionsRequired"] = {"EXT_lights_area"};
    file.json["extensions"]["EXT_lights_area"]["lights"] = {light};
    file.json["scenes"][0]["nodes"] = {0, 1};
    Json lit = {{"name", "Panel"}, {"extensions", {{"EXT_lights_area", {{"light", 0}}}}}};
    lit.update(node);
    file.json["nodes"].push_back(lit);
    return file;
}

TEST(AreaLightFiles, RectanglesTakeTheLargestScaleOfTheirNode)
{
    const TemporaryFolder folder;
    const auto scene = readScene(
        fileWith(
            {{"type", "rect"}, {"color", {1, 0.5, 0.25}}, {"intensity", 250}, {"size", 0.5}, {"rect", {{"aspect", 3}}}},
            {{"translation", {1, 2, 3}}, {"scale", {1, -2, 0.5}}})
            .write(folder));
    ASSERT_TRUE(scene) << scene.error().text();
    EXPECT_THAT(scene->warnings, Not(Contains(HasSubstr("light"))));
    const Light& light = scene->lights.at(0);
    EXPECT_EQ(light.type, LightType::Rectangle);
    EXPECT_EQ(light.name, "Panel");
    EXPECT_EQ(light.color, vec3(1, 0.5f, 0.25f));
    EXPECT_EQ(light.intensity, 250.0f);
    EXPECT_EQ(light.sizeMeters, vec2(3.0f, 1.0f));
    EXPECT_EQ(light.position(), vec3(1, 2, 3));
    EXPECT_FLOAT_EQ(light.area(), 3.0f);
    EXPECT_EQ(int(light.mode), int(LightMode::Mixed));
}

TEST(AreaLightFiles, DisksAndDefaults)
{
    const TemporaryFolder folder;
    const auto scene = readScene(fileWith({{"type", "disk"}}).write(folder));
    ASSERT_TRUE(scene) << scene.error().text();
    EXPECT_EQ(scene->lights.at(0).type, LightType::Disk);
    EXPECT_EQ(scene->lights[0].intensity, 1000.0f);
    EXPECT_EQ(scene->lights[0].sizeMeters.x, 1.0f);
    EXPECT_FLOAT_EQ(scene->lights[0].area(), kPi / 4.0f);
    EXPECT_EQ(scene->lights[0].direction(), vec3(0, 0, -1));
}

TEST(AreaLightFiles, WrongValuesAreToldByTheirPath)
{
    const TemporaryFolder folder;
    for (const auto& [light, sentence] : {std::pair<Json, const char*>{{{"type", "sphere"}}, "rect or disk"},
                                          {Json::object(), "rect or disk"},
                                          {{{"type", "rect"}, {"size", -1}}, "size"},
                                          {{{"type", "rect"}, {"rect", {{"aspect", -2}}}}, "aspect"},
                                          {{{"type", "rect"}, {"size", "big"}}, "size"},
                                          {{{"type", "disk"}, {"intensity", -3}}, "intensity"}}) {
        const auto scene = readScene(fileWith(light).write(folder));
        ASSERT_FALSE(scene) << light;
        EXPECT_THAT(scene.error().text(), HasSubstr(sentence));
        EXPECT_THAT(scene.error().text(), HasSubstr("EXT_lights_area/lights"));
    }
    auto missing = fileWith({{"type", "rect"}});
    missing.json["nodes"][1]["extensions"]["EXT_lights_area"]["light"] = 7;
    EXPECT_FALSE(readScene(missing.write(folder)));
}

TEST(AreaLightFiles, LightsWithoutSizeAndSecondLightsAreLeftOutWithAWarning)
{
    const TemporaryFolder folder;
    const auto flat = readScene(fileWith({{"type", "rect"}, {"size", 0}}).write(folder));
    ASSERT_TRUE(flat) << flat.error().text();
    EXPECT_THAT(flat->lights, IsEmpty());
    EXPECT_THAT(flat->warnings, Contains(HasSubstr("Panel is left out")));

    auto two = fileWith({{"type", "rect"}});
    two.json["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}}};
    two.json["nodes"][1]["extensions"]["KHR_lights_punctual"]["light"] = 0;
    const auto scene = readScene(two.write(folder));
    ASSERT_TRUE(scene) << scene.error().text();
    ASSERT_EQ(scene->lights.size(), 1u);
    EXPECT_EQ(scene->lights[0].type, LightType::Point);
    EXPECT_THAT(scene->warnings, Contains(HasSubstr("has two lights")));
}

GltfBuilder fileWithExtras(const Json& extras)
{
    GltfBuilder file;
    file.triangle();
    file.json["scenes"][0]["nodes"] = {0, 1};
    file.json["nodes"].push_back({{"name", "Window"}, {"scale", {2, 2, 2}}, {"extras", extras}});
    return file;
}

TEST(AreaLightFiles, NodesBecomeAreaLightsByTheirExtras)
{
    const TemporaryFolder folder;
    const auto scene = readScene(fileWithExtras({{"halflight_area_light", "rectangle"},
                                                 {"halflight_size", {1.2, 0.8}},
                                                 {"halflight_intensity", 40},
                                                 {"halflight_mode", "baked"},
                                                 {"halflight_range", 9}})
                                     .write(folder));
    ASSERT_TRUE(scene) << scene.error().text();
    EXPECT_THAT(scene->warnings, Not(Contains(HasSubstr("light"))));
    const Light& light = scene->lights.at(0);
    EXPECT_EQ(light.type, LightType::Rectangle);
    EXPECT_EQ(light.name, "Window");
    EXPECT_EQ(light.sizeMeters, vec2(1.2f, 0.8f)) << "metres, whatever the node's scale";
    EXPECT_EQ(light.intensity, 40.0f);
    EXPECT_EQ(light.rangeMeters, 9.0f);
    EXPECT_EQ(int(light.mode), int(LightMode::Baked));

    for (const Json& wrong : {Json{{"halflight_area_light", "point"}}, Json{{"halflight_area_light", 3}},
                              Json{{"halflight_area_light", "disk"}, {"halflight_size", 0}},
                              Json{{"halflight_area_light", "disk"}, {"halflight_size", {1, 2, 3}}}}) {
        EXPECT_FALSE(readScene(fileWithExtras(wrong).write(folder))) << wrong;
    }
    auto punctual = fileWithExtras({{"halflight_area_light", "disk"}});
    punctual.json["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}}};
    punctual.json["nodes"][1]["extensions"]["KHR_lights_punctual"]["light"] = 0;
    const auto refused = readScene(punctual.write(folder));
    ASSERT_FALSE(refused);
    EXPECT_THAT(refused.error().text(), HasSubstr("a node of its own"));
}

TEST(AreaLightFiles, SettingsFilesAddThemAndSetTheirSize)
{
    const TemporaryFolder folder;
    const auto file = fileWith({{"type", "rect"}}).write(folder);
    const auto settings = folder / "a.toml";
    writeText(settings, R"(
[[light]]
pattern = "Panel"
size = [2, 0.5]
radius = 1
[[add_light]]
type = "disk"
name = "Lamp"
size = 0.3
intensity = 500
position = [0, 2, 0]
[[node]]
pattern = "triangle"
area_light = "disk"
)");
    const auto scene = readScene(file, {.settingsFile = settings});
    ASSERT_TRUE(scene) << scene.error().text();
    ASSERT_EQ(scene->lights.size(), 3u);
    EXPECT_EQ(scene->lights[0].type, LightType::Disk);
    EXPECT_EQ(scene->lights[1].sizeMeters, vec2(2.0f, 0.5f));
    EXPECT_EQ(scene->lights[2].type, LightType::Disk);
    EXPECT_EQ(scene->lights[2].sizeMeters.x, 0.3f);
    EXPECT_EQ(scene->lights[2].intensity, 500.0f);
    EXPECT_EQ(scene->lights[2].direction(), vec3(0, -1, 0));
    EXPECT_THAT(scene->warnings, Contains(HasSubstr("its radius has no effect")));

    auto lamp = fileWith({{"type", "rect"}});
    lamp.json["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}, {"name", "Bulb"}}};
    lamp.json["nodes"].push_back(
        {{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}, {"extras", {{"halflight_size", 2}}}});
    lamp.json["scenes"][0]["nodes"] = {0, 1, 2};
    const auto bulb = readScene(lamp.write(folder));
    ASSERT_TRUE(bulb) << bulb.error().text();
    EXPECT_THAT(bulb->warnings, Contains(HasSubstr("Bulb is no area light, so its size has no effect")));
}

// What a baked file holds is what the bake had, whichever way the light came into it, and can be baked again.
TEST(AreaLightFiles, BakedFilesGiveThemBack)
{
    const TemporaryFolder folder;
    const auto settings = folder / "a.toml";
    writeText(settings, R"(
[[light]]
pattern = "*"
size = [0.7, 0.6]
range = 12
intensity = 77
[[add_light]]
type = "disk"
name = "Lamp"
size = 0.3
position = [0, 2, 0]
)");
    for (const bool byExtras : {false, true}) {
        const auto file =
            byExtras ? fileWithExtras({{"halflight_area_light", "rectangle"}, {"halflight_size", 3}}).write(folder)
                     : fileWith({{"type", "rect"}, {"size", 5}}, {{"scale", {2, 2, 2}}}).write(folder);
        const auto scene = readScene(file, {.settingsFile = settings});
        ASSERT_TRUE(scene) << scene.error().text();
        const BakedScene baked = pretendToBake(*scene);
        ASSERT_TRUE(writeBakedScene(folder / "baked.glb", baked));
        const Json json = jsonOfGlb(folder / "baked.glb");
        EXPECT_THAT(json["extensionsUsed"], Contains("EXT_lights_area"));
        EXPECT_EQ(json["extensions"]["EXT_lights_area"]["lights"].size(), 2u);
        EXPECT_FALSE(json["extensions"].contains("KHR_lights_punctual"));
        const auto read = readBakedScene(folder / "baked.glb");
        ASSERT_TRUE(read) << read.error().text();
        ASSERT_EQ(read->scene.lights.size(), 2u);
        for (std::size_t i = 0; i < 2; ++i) {
            const Light& was = baked.scene.lights[i];
            const Light& is = read->scene.lights[i];
            EXPECT_EQ(is.type, was.type);
            EXPECT_NEAR(is.sizeMeters.x, was.sizeMeters.x, 1e-6f);
            EXPECT_NEAR(is.sizeMeters.y, i == 0 ? was.sizeMeters.y : 0.3f, 1e-6f);
            EXPECT_EQ(is.rangeMeters, was.rangeMeters);
            EXPECT_EQ(is.intensity, was.intensity);
            EXPECT_FALSE(movedSinceBake(is));
            EXPECT_THAT(changesSinceBake(is, "light", true), IsEmpty());
        }
        EXPECT_EQ(read->scene.lights[0].sizeMeters, vec2(0.7f, 0.6f));
        // Baked once more, with the same settings: nothing piles up.
        const auto again = readScene(folder / "baked.glb", {.settingsFile = settings});
        ASSERT_TRUE(again) << again.error().text();
        EXPECT_EQ(again->lights.size(), 2u);
    }
}

// Turned about its axis a rectangle is another light, a disk is not; half a turn changes neither.
TEST(AreaLightFiles, TurnsAboutTheAxisCountForRectangles)
{
    for (const LightType type : {LightType::Rectangle, LightType::Disk}) {
        Light light;
        light.type = type;
        light.sizeMeters = vec2(2.0f, 1.0f);
        light.baking.isBaked = true;
        light.baking.bakeType = LightMode::Mixed;
        EXPECT_FALSE(movedSinceBake(light));
        light.worldFromLight = mat4(vec4(-1, 0, 0, 0), vec4(0, -1, 0, 0), vec4(0, 0, 1, 0), vec4(0, 0, 0, 1));
        EXPECT_FALSE(movedSinceBake(light));
        light.worldFromLight = mat4(vec4(0, 1, 0, 0), vec4(-1, 0, 0, 0), vec4(0, 0, 1, 0), vec4(0, 0, 0, 1));
        EXPECT_EQ(movedSinceBake(light), type == LightType::Rectangle);
    }
}

} // namespace
} // namespace halflight::area_lights_test
