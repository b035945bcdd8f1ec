// Settings: extras, then the settings file; typos and wrong values are errors.

#include "fixtures.h"
#include "scene/settings/settings.h"

#include <gmock/gmock.h>

namespace halflight::settings_test {
namespace {

using namespace test;
using testing::Contains;
using testing::HasSubstr;

GltfBuilder litFile()
{
    GltfBuilder file;
    file.triangle();
    file.json["extensionsUsed"] = {"KHR_lights_punctual"};
    file.json["extensions"]["KHR_lights_punctual"]["lights"] = {
        {{"type", "directional"}, {"name", "Sun"}},
        {{"type", "point"}, {"name", "Lamp 1"}, {"extras", {{"halflight_mode", "baked"}, {"halflight_radius", 0.5}}}}};
    file.json["scenes"][0]["nodes"] = {0, 1, 2};
    file.json["scenes"][0]["extras"] = {{"halflight_sky", 2},
                                        {"halflight_sky_ground", {0.1, 0.2, 0.3}},
                                        {"halflight_shadow_color", {0.01, 0.02, 0.03}},
                                        {"halflight_probes", {1, 2, 3, 4, 5, 6}}};
    file.json["nodes"][0]["extras"] = {{"halflight_static", 0},          {"halflight_cast_shadows", false},
                                       {"halflight_receive_shadows", 1}, {"halflight_lightmap_scale", 2.5},
                                       {"halflight_probes", "volume"},   {"halflight_probe_resolution", {4, 5.0, 6}}};
    file.json["nodes"][0]["children"] = {3};
    file.json["nodes"].push_back(
        {{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}},
         {"extras",
          {{"halflight_mode", "realtime"}, {"halflight_angular_diameter", 0.53}, {"halflight_intensity", 7}}}});
    file.json["nodes"].push_back({{"extensions", {{"KHR_lights_punctual", {{"light", 1}}}}}});
    file.json["nodes"].push_back({{"name", "Child"}, {"mesh", 0}});
    return file;
}

TEST(SettingsS5, ExtrasOfNodesLightsAndScene)
{
    const TemporaryFolder folder;
    const auto scene = readScene(litFile().write(folder));
    ASSERT_TRUE(scene) << scene.error().text();
    const Object& object = scene->objects.at(0);
    EXPECT_FALSE(object.isStatic);
    EXPECT_FALSE(object.castShadows);
    EXPECT_TRUE(object.receiveShadows);
    EXPECT_EQ(object.lightmapScale, 2.5f);
    EXPECT_EQ(int(object.probeLighting), int(ProbeLighting::Volume));
    EXPECT_EQ(object.probeResolution, ivec3(4, 5, 6));
    EXPECT_EQ(int(scene->objects.at(1).probeLighting), int(ProbeLighting::Automatic)); // not inherited
    EXPECT_FALSE(scene->objects.at(1).isStatic);                                       // inherited
    EXPECT_TRUE(scene->objects.at(1).castShadows);                                     // not inherited
    EXPECT_EQ(int(scene->lights.at(0).mode), int(LightMode::Realtime));
    EXPECT_EQ(scene->lights[0].intensity, 7.0f);
    EXPECT_FLOAT_EQ(scene->lights[0].angularRadiusRadians, glm::radians(0.265f));
    EXPECT_EQ(int(scene->lights.at(1).mode), int(LightMode::Baked));
    EXPECT_EQ(scene->lights[1].radiusMeters, 0.5f);
    EXPECT_EQ(scene->sky.zenith, vec3(2.0f));
    EXPECT_EQ(scene->sky.ground, vec3(0.1f, 0.2f, 0.3f));
    EXPECT_EQ(scene->subtractiveShadowColor, vec3(0.01f, 0.02f, 0.03f));
    EXPECT_EQ(scene->probePositions, (std::vector<vec3>{{1, 2, 3}, {4, 5, 6}}));
}

// Extras of materials, the settings file over them, and both in the written file, in the copies with lightmaps too.
TEST(SettingsS30, SwitchesOfMaterials)
{
    const TemporaryFolder folder;
    GltfBuilder file;
    file.triangle();
    file.json["materials"] = {{{"name", "glass"}, {"extras", {{"halflight_cast_shadows", 0}}}},
                              {{"name", "film"}, {"extras", {{"halflight_receive_shadows", false}}}},
                              {{"name", "stone"}, {"extras", {{"halflight_statc", 1}}}}};
    file.json["meshes"][0]["primitives"][0]["material"] = 1;
    const std::filesystem::path path = file.write(folder);
    const auto switches = [](const Scene& scene) {
        std::vector<std::pair<bool, bool>> list;
        for (const Material& material : scene.materials)
            list.emplace_back(material.castShadows, material.receiveShadows);
        return list;
    };
    using List = std::vector<std::pair<bool, bool>>;
    const auto authored = readScene(path);
    ASSERT_TRUE(authored) << authored.error().text();
    EXPECT_EQ(switches(*authored), (List{{false, true}, {true, false}, {true, true}}));
    EXPECT_THAT(authored->warnings, Contains(HasSubstr("/materials/2/extras: unknown key halflight_statc")));

    writeText(folder / "s.toml", "[[material]]\npattern = \"*l*\"\ncast_shadows = true\nreceive_shadows = false\n"
                                 "[[material]]\npattern = \"wood\"\n");
    const auto scene = readScene(path, {.settingsFile = folder / "s.toml"});
    ASSERT_TRUE(scene) << scene.error().text();
    EXPECT_EQ(switches(*scene), (List{{true, false}, {true, false}, {true, true}}));
    EXPECT_THAT(scene->warnings, Contains(HasSubstr("\"wood\" of [[material]] matches nothing")));

    ASSERT_TRUE(writeBakedScene(folder / "baked.glb", pretendToBake(*scene)));
    const auto baked = readBakedScene(folder / "baked.glb");
    ASSERT_TRUE(baked) << baked.error().text();
    for (const Object& object : baked->scene.objects) {
        const Material& material = materialOf(baked->scene, baked->scene.meshes[std::size_t(object.mesh)].parts[0]);
        EXPECT_TRUE(material.castShadows);
        EXPECT_FALSE(material.receiveShadows);
    }
    // The stronger record lasts through another bake, and a settings file overrules it.
    writeText(folder / "t.toml", "[[material]]\npattern = \"film\"\nreceive_shadows = true\n");
    const auto again = readScene(folder / "baked.glb", {.settingsFile = folder / "t.toml"});
    ASSERT_TRUE(again) << again.error().text();
    EXPECT_EQ(switches(*again), (List{{true, false}, {true, true}, {true, true}}));
    ASSERT_TRUE(writeBakedScene(folder / "again.glb", pretendToBake(*again)));
    const Json json = jsonOfGlb(folder / "again.glb");
    EXPECT_TRUE(json["materials"][0]["extensions"].contains("HALFLIGHT_material"));
    EXPECT_FALSE(json["materials"][1].value("extensions", Json::object()).contains("HALFLIGHT_material"));
}

// Biases of a light: extras, a stronger settings file, and a baked file that keeps them; 0 is a bias, too.
TEST(SettingsS2, BiasesOfALight)
{
    const TemporaryFolder folder;
    GltfBuilder file = litFile();
    file.json["nodes"][1]["extras"]["halflight_depth_bias"] = 0;
    file.json["nodes"][1]["extras"]["halflight_normal_bias"] = 2.5;
    writeText(folder / "s.toml", "[[light]]\npattern = \"Sun\"\nslope_bias = 7\nnormal_bias = 8\n");
    const auto path = file.write(folder);
    auto scene = readScene(path, {.settingsFile = folder / "s.toml"});
    ASSERT_TRUE(scene) << scene.error().text();
    ASSERT_TRUE(writeBakedScene(folder / "baked.glb", pretendToBake(std::move(*scene))));
    const auto baked = readBakedScene(folder / "baked.glb");
    ASSERT_TRUE(baked) << baked.error().text();
    const ShadowBias& sun = baked->scene.lights.at(0).shadowBias;
    EXPECT_EQ(sun.depthTexels, std::optional(0.0f));
    EXPECT_EQ(sun.slope, std::optional(7.0f));
    EXPECT_EQ(sun.normalTexels, std::optional(8.0f));
    const ShadowBias& lamp = baked->scene.lights.at(1).shadowBias;
    EXPECT_FALSE(lamp.depthTexels || lamp.slope || lamp.normalTexels);
    for (const char* wrong : {"normal_bias = 9", "normal_bias = -1", "depth_bias = 101", "slope_bias = \"a\""}) {
        writeText(folder / "s.toml", std::string("[[light]]\npattern = \"Sun\"\n") + wrong);
        EXPECT_FALSE(readScene(path, {.settingsFile = folder / "s.toml"})) << wrong;
    }
}

// A light that a settings file added keeps what the bake made of it when the baked file is read with the same settings.
TEST(SettingsS5, AnAddedLightKeepsItsBake)
{
    const TemporaryFolder folder;
    writeText(folder / "s.toml", "[[add_light]]\ntype = \"point\"\nname = \"bulb\"\nintensity = 3\n");
    auto scene = readScene(litFile().write(folder), {.settingsFile = folder / "s.toml"});
    ASSERT_TRUE(scene) << scene.error().text();
    BakedScene bake = pretendToBake(std::move(*scene));
    BakingOutput& output = bake.scene.lights.back().baking;
    output.isBaked = true;
    output.bakeType = LightMode::Mixed;
    output.occlusionMaskChannel = 3;
    ASSERT_TRUE(writeBakedScene(folder / "baked.glb", bake));
    const auto baked = readBakedScene(folder / "baked.glb", {.settingsFile = folder / "s.toml"});
    ASSERT_TRUE(baked) << baked.error().text();
    ASSERT_EQ(baked->scene.lights.back().name, "bulb");
    EXPECT_TRUE(baked->scene.lights.back().baking.isBaked);
    EXPECT_EQ(baked->scene.lights.back().baking.occlusionMaskChannel, 3);
}

// S23. What the bake chose is no wish of the author's: another bake chooses anew. The author's colour stays, black too.
TEST(SettingsS23, ShadowColorOfTheBakeAndOfTheAuthor)
{
    const TemporaryFolder folder;
    for (const std::optional<vec3> color :
         {std::optional<vec3>(), std::optional(vec3(0.0f)), std::optional(vec3(2.0f))}) {
        Scene scene = engineScene();
        scene.subtractiveShadowColor = color;
        const BakedScene baked = pretendToBake(scene);
        ASSERT_TRUE(writeBakedScene(folder / "baked.glb", baked));
        const Json root = jsonOfGlb(folder / "baked.glb")["extensions"]["HALFLIGHT_mixed_lighting"];
        EXPECT_EQ(root["shadowColorFromBake"], !color.has_value());
        const auto read = readBakedScene(folder / "baked.glb");
        ASSERT_TRUE(read) << read.error().text();
        EXPECT_EQ(read->scene.subtractiveShadowColor, color);
        EXPECT_EQ(subtractiveShadowColor(*read), color.value_or(baked.defaultShadowColor));
        const auto again = readScene(folder / "baked.glb");
        ASSERT_TRUE(again) << again.error().text();
        EXPECT_EQ(again->subtractiveShadowColor, color);
    }
}

constexpr const char* kStrongerFile = R"(
[sky]
color = 3.0
zenith = [1, 2, 3]
[scene]
shadow_color = [1, 1, 1]
probes = [[9, 8, 7]]
[[node]]
pattern = "tri*"
static = true
cast_shadows = true
receive_shadows = false
[[node]]
pattern = "Chil?"
lightmap_scale = 0.5
probes = "single"
probe_resolution = 7
[[node]]
pattern = "nobody"
static = false
[[light]]
pattern = "*"
mode = "mixed"
shadow_strength = 0.25
[[light]]
pattern = "Lamp*"
indirect_multiplier = 2
range = 4.5
cast_shadows = false
[[add_light]]
type = "spot"
name = "Extra"
position = [1, 2, 3]
direction = [0, -2, 0]
color = [1, 0, 0]
intensity = 100
inner_cone_degrees = 10
outer_cone_degrees = 20
radius = 0.1
)";

TEST(SettingsS5, FileIsStrongerThanExtras)
{
    const TemporaryFolder folder;
    writeText(folder / "s.toml", kStrongerFile);
    const auto scene = readScene(litFile().write(folder), {.settingsFile = folder / "s.toml"});
    ASSERT_TRUE(scene) << scene.error().text();
    EXPECT_TRUE(scene->objects.at(0).isStatic);
    EXPECT_TRUE(scene->objects[0].castShadows); // off in its extras
    EXPECT_FALSE(scene->objects[0].receiveShadows);
    EXPECT_TRUE(scene->objects.at(1).isStatic); // the file's rule for the parent beats the parent's extras
    EXPECT_EQ(scene->objects[1].lightmapScale, 0.5f);
    EXPECT_EQ(int(scene->objects[1].probeLighting), int(ProbeLighting::Single));
    EXPECT_EQ(scene->objects[1].probeResolution, ivec3(7));
    EXPECT_EQ(int(scene->lights.at(0).mode), int(LightMode::Mixed));
    EXPECT_EQ(scene->lights[0].shadowStrength, 0.25f);
    EXPECT_EQ(int(scene->lights.at(1).mode), int(LightMode::Mixed));
    EXPECT_EQ(scene->lights[1].rangeMeters, 4.5f);
    EXPECT_FALSE(scene->lights[1].castShadows);
    EXPECT_EQ(scene->lights[1].indirectMultiplier, 2.0f);
    ASSERT_EQ(scene->lights.size(), 3u);
    EXPECT_EQ(scene->lights[2].name, "Extra");
    EXPECT_EQ(scene->lights[2].position(), vec3(1, 2, 3));
    EXPECT_LT(glm::distance(scene->lights[2].direction(), vec3(0, -1, 0)), 1.0e-6f);
    EXPECT_FLOAT_EQ(scene->lights[2].outerConeRadians, glm::radians(20.0f));
    EXPECT_EQ(scene->sky.zenith, vec3(1, 2, 3));
    EXPECT_EQ(scene->sky.horizon, vec3(3.0f));
    EXPECT_EQ(scene->probePositions, (std::vector<vec3>{{9, 8, 7}}));
    EXPECT_THAT(scene->warnings, Contains(HasSubstr("\"nobody\"")));
}

TEST(SettingsS5, FileAddsItsLightsOnce)
{
    const TemporaryFolder folder;
    writeText(folder / "s.toml", kStrongerFile);
    const auto scene = readScene(litFile().write(folder), {.settingsFile = folder / "s.toml"});
    ASSERT_TRUE(scene) << scene.error().text();
    // Written, read back without the settings file, and baked again with it.
    ASSERT_TRUE(writeBakedScene(folder / "baked.glb", pretendToBake(*scene)));
    const auto baked = readBakedScene(folder / "baked.glb");
    ASSERT_TRUE(baked) << baked.error().text();
    ASSERT_EQ(baked->scene.lights.size(), 3u);
    EXPECT_EQ(baked->scene.lights[0].intensity, 7.0f);
    EXPECT_EQ(baked->scene.lights[1].rangeMeters, 4.5f);
    EXPECT_EQ(baked->scene.lights[2].name, "Extra");
    EXPECT_EQ(baked->scene.lights[2].intensity, 100.0f);
    EXPECT_TRUE(baked->scene.objects[0].isStatic);
    const auto again = readScene(folder / "baked.glb", {.settingsFile = folder / "s.toml"});
    ASSERT_TRUE(again) << again.error().text();
    EXPECT_EQ(again->lights.size(), 3u);
}

TEST(SettingsS5, TyposAndWrongValuesAreErrors)
{
    const TemporaryFolder folder;
    const auto path = litFile().write(folder);
    const auto errorOf = [&](const char* text) {
        writeText(folder / "s.toml", text);
        const auto scene = readScene(path, {.settingsFile = folder / "s.toml"});
        return scene ? std::string("loaded") : scene.error().text();
    };
    EXPECT_THAT(errorOf("[[light]]\npattern = \"*\"\nshadow_strenght = 1\n"),
                HasSubstr("unknown key \"shadow_strenght\""));
    EXPECT_THAT(errorOf("[[light]]\npattern = \"*\"\nshadow_strength = 1.5\n"),
                HasSubstr("shadow_strength must be a number from 0 to 1"));
    EXPECT_THAT(errorOf("[[light]]\npattern = \"*\"\nmode = \"backed\"\n"), HasSubstr("mode must be"));
    EXPECT_THAT(errorOf("[[light]]\nmode = \"baked\"\n"), HasSubstr("pattern must be"));
    EXPECT_THAT(errorOf("[light]\nmode = \"baked\"\n"), HasSubstr("[[light]]"));
    EXPECT_THAT(errorOf("[lights]\n"), HasSubstr("unknown table \"lights\""));
    EXPECT_THAT(errorOf("[sky]\nzenith = [1, 2]\n"), HasSubstr("zenith must be three numbers"));
    EXPECT_THAT(errorOf("[sky]\nzenith = \n"), HasSubstr("line 2"));
    EXPECT_THAT(errorOf("[[add_light]]\nname = \"x\"\n"), HasSubstr("type must be"));
    EXPECT_THAT(errorOf("[[node]]\npattern = \"*\"\nstatic = 2\n"), HasSubstr("static must be true, false, 0 or 1"));
    EXPECT_THAT(errorOf("[[node]]\npattern = \"*\"\nprobes = \"many\"\n"), HasSubstr("\"single\" or \"volume\""));
    for (const char* wrong : {"65", "0", "1.5", "[1, 2]", "\"8\""})
        EXPECT_THAT(errorOf((std::string("[[node]]\npattern = \"*\"\nprobe_resolution = ") + wrong + "\n").c_str()),
                    HasSubstr("a whole number from 1 to 64, or three"));
    EXPECT_EQ(readScene(path, {.settingsFile = folder / "none.toml"}).error().code, ErrorCode::FileNotFound);

    // A typo in extras is a warning: the file may come from another version.
    GltfBuilder file = litFile();
    file.json["nodes"][0]["extras"]["halflight_statik"] = 1;
    const auto scene = readScene(file.write(folder));
    ASSERT_TRUE(scene);
    EXPECT_THAT(scene->warnings, Contains(HasSubstr("halflight_statik")));
}

TEST(SettingsS5, Patterns)
{
    EXPECT_TRUE(matchesPattern("*", ""));
    EXPECT_TRUE(matchesPattern("a*c", "abbc"));
    EXPECT_TRUE(matchesPattern("a*b*c", "aXbbYc"));
    EXPECT_TRUE(matchesPattern("?b", "ab"));
    EXPECT_FALSE(matchesPattern("?b", "b"));
    EXPECT_FALSE(matchesPattern("a*c", "abcd"));
    EXPECT_FALSE(matchesPattern("", "a"));
    EXPECT_TRUE(matchesPattern("*****a", std::string(2000, 'b') + "a"));
}

} // namespace
} // namespace halflight::settings_test
