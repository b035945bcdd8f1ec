// A baked file that was changed since its bake says so when it is read.

#include "fixtures.h"

#include <gmock/gmock.h>

namespace halflight::stale_test {
namespace {

using namespace test;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class StaleFile : public testing::Test {
protected:
    void SetUp() override
    {
        BakedScene baked = pretendToBake(engineScene(), false);
        for (Texture& texture : baked.scene.textures)
            if (texture.pixels.empty()) texture.pixels = ImageRgba8(2, 2, u8vec4(9));
        baked.scene.lights.back().baking.bakeType = LightMode::Baked;
        for (Light& light : baked.scene.lights) {
            light.baking.outerConeRadians = light.outerConeRadians;
            light.baking.atBake = lightAtBake(light);
        }
        baked.scene.warnings.clear();
        const Status status = writeBakedScene(file, baked);
        ASSERT_TRUE(status) << status.error().text();
    }

    /// What reading the file warns of after `change`.
    template<typename Change> std::vector<std::string> warningsAfter(const Change& change)
    {
        Result<BakedScene> read = readBakedScene(file);
        if (!read) return {"unreadable: " + read.error().text()};
        EXPECT_THAT(read->scene.warnings, IsEmpty());
        // The records of before stay: that is what an editor leaves that knows nothing of them.
        std::vector<char> binary;
        Json json = jsonOfGlb(file, &binary);
        change(json);
        json["buffers"][0]["uri"] = "binary.bin";
        writeText(folder / "binary.bin", std::string(binary.begin(), binary.end()));
        writeText(folder / "changed.gltf", json.dump());
        Result<BakedScene> changed = readBakedScene(folder / "changed.gltf");
        return changed ? changed->scene.warnings : std::vector{"unreadable: " + changed.error().text()};
    }

    static std::size_t nodeWith(const Json& json, const char* extension, const char* key)
    {
        for (std::size_t i = 0; i < json["nodes"].size(); ++i) {
            const Json& node = json["nodes"][i];
            if (node.contains("extensions") && node["extensions"].contains(extension) &&
                node["extensions"][extension].dump().find(key) != std::string::npos)
                return i;
        }
        return std::size_t(-1);
    }

    TemporaryFolder folder;
    std::filesystem::path file = folder / "baked.glb";
};

TEST_F(StaleFile, AnUntouchedFileIsFresh)
{
    EXPECT_THAT(warningsAfter([](Json&) {}), IsEmpty());
}

TEST_F(StaleFile, AMovedStaticObjectIsNamed)
{
    std::string name;
    const auto warnings = warningsAfter([&](Json& json) {
        Json& node = json["nodes"][nodeWith(json, "HALFLIGHT_node", "atBake")];
        name = node.value("name", "");
        Json matrix = node.value("matrix", Json({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}));
        matrix[12] = matrix[12].get<double>() + 0.25;
        node["matrix"] = matrix;
    });
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_THAT(warnings[0], HasSubstr("is stale"));
    EXPECT_THAT(warnings[0], HasSubstr(name));
}

TEST_F(StaleFile, AChangedMaterialMakesItsObjectsStale)
{
    const auto warnings = warningsAfter([](Json& json) {
        for (Json& material : json["materials"])
            material["pbrMetallicRoughness"]["baseColorFactor"] = {0.1, 0.2, 0.3, 1};
    });
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_THAT(warnings[0], HasSubstr("objects"));
}

TEST_F(StaleFile, AColorOfAMixedLightMayChangeAndABakedOneMayNot)
{
    const auto recolor = [](const char* bakeType) {
        return [bakeType](Json& json) {
            const std::string key = std::string("\"bakeType\":\"") + bakeType;
            const Json& node = json["nodes"][nodeWith(json, "HALFLIGHT_light", key.c_str())];
            const bool area = node["extensions"].contains("EXT_lights_area");
            const char* extension = area ? "EXT_lights_area" : "KHR_lights_punctual";
            const auto light = node["extensions"][extension]["light"].get<std::size_t>();
            json["extensions"][extension]["lights"][light]["intensity"] = 30.0;
        };
    };
    EXPECT_THAT(warningsAfter(recolor("mixed")), IsEmpty());
    const auto warnings = warningsAfter(recolor("baked"));
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_THAT(warnings[0], HasSubstr("so it is fully baked"));
}

// Subtractive lightmaps hold direct light of mixed lights, too.
TEST_F(StaleFile, AChangedMixedLightMakesASubtractiveFileStale)
{
    for (const MixedLightingMode mode : {MixedLightingMode::Subtractive, MixedLightingMode::Shadowmask}) {
        BakedScene baked = pretendToBake(engineScene(), false);
        for (Texture& texture : baked.scene.textures)
            if (texture.pixels.empty()) texture.pixels = ImageRgba8(2, 2, u8vec4(9));
        baked.mode = mode;
        for (Light& light : baked.scene.lights) {
            light.mode = light.baking.bakeType = LightMode::Mixed;
            light.baking.isBaked = true;
            light.baking.mixedMode = mode;
            light.baking.reachMeters = light.rangeMeters;
            light.baking.outerConeRadians = light.outerConeRadians;
            light.baking.atBake = lightAtBake(light);
        }
        baked.scene.warnings.clear();
        ASSERT_TRUE(writeBakedScene(file, baked));
        const auto brighten = [](float factor) {
            return [factor](Json& json) {
                Json& light = json["extensions"]["KHR_lights_punctual"]["lights"][0];
                light["intensity"] = factor * light.value("intensity", 1.0f);
            };
        };
        const auto doubled = warningsAfter(brighten(2.0f));
        const auto tenfold = warningsAfter(brighten(10.0f));
        ASSERT_EQ(tenfold.size(), 1u);
        if (mode == MixedLightingMode::Subtractive) {
            ASSERT_EQ(doubled.size(), 1u);
            EXPECT_THAT(doubled[0], AllOf(HasSubstr("is stale"), HasSubstr("static objects")));
        } else {
            EXPECT_THAT(doubled, IsEmpty());
            EXPECT_THAT(tenfold[0], AllOf(HasSubstr("is stale"), HasSubstr("bounced light")));
        }
    }
}

// Settings that only a bake can heed have no effect on a baked file, and say so; those that a renderer heeds say
// nothing.
TEST_F(StaleFile, SettingsThatOnlyABakeHeedsAreNamed)
{
    const auto warningsWith = [&](const std::string& toml) {
        writeText(folder / "settings.toml", toml);
        Result<BakedScene> read = readBakedScene(file, {.settingsFile = folder / "settings.toml"});
        return read ? read->scene.warnings : std::vector{"unreadable: " + read.error().text()};
    };
    const Result<BakedScene> plain = readBakedScene(file);
    ASSERT_TRUE(plain);
    const Light& light = plain->scene.lights.front();
    const std::string rule = "[[light]]\npattern = \"" + light.name + "\"\n";
    const char* other = light.mode == LightMode::Baked ? "mixed" : "baked";
    EXPECT_THAT(warningsWith(rule + "mode = \"" + other + "\""),
                ElementsAre(AllOf(HasSubstr("mode of"), HasSubstr(light.name), HasSubstr("no effect"))));
    EXPECT_THAT(warningsWith(rule + "mode = \"" + nameOf(light.mode) + "\""), IsEmpty()) << "as at the bake";
    EXPECT_THAT(warningsWith(rule + "indirect_multiplier = 7"), ElementsAre(HasSubstr("indirect_multiplier of")));
    EXPECT_THAT(warningsWith("[[node]]\npattern = \"*\"\nlightmap_scale = 3"),
                ElementsAre(HasSubstr("lightmap_scale of")));
    EXPECT_THAT(warningsWith("[scene]\nprobes = [[0, 1, 0], [0, 2, 0], [1, 2, 0], [1, 3, 0], [2, 2, 2]]"),
                ElementsAre(HasSubstr("probes has no effect")));
    EXPECT_THAT(warningsWith("[[add_light]]\ntype = \"point\"\nname = \"new\""),
                ElementsAre(AllOf(HasSubstr("new"), HasSubstr("not in the bake"))));
    EXPECT_THAT(warningsWith("[[add_light]]\ntype = \"point\"\nname = \"new\"\nmode = \"realtime\""), IsEmpty());
    EXPECT_THAT(warningsWith(rule + "normal_bias = 3\nshadow_strength = " + std::to_string(light.shadowStrength)),
                IsEmpty());
}

TEST_F(StaleFile, AChangedSkyIsStale)
{
    const auto warnings = warningsAfter([](Json& json) {
        json["extensions"]["HALFLIGHT_mixed_lighting"]["sky"]["zenith"] = {7, 7, 7};
    });
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_THAT(warnings[0], HasSubstr("sky"));
}

} // namespace
} // namespace halflight::stale_test
