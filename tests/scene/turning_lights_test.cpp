// S34. Lights that turn: weights of their directions, what authors write, and groups.

#include "fixtures.h"

#include "halflight/scene/gltf.h"
#include "halflight/scene/light_groups.h"
#include "halflight/scene/turning_lights.h"

#include <gmock/gmock.h>

#include <glm/gtx/quaternion.hpp>

#include <cmath>
#include <numeric>
#include <random>

namespace halflight::turning_lights_test {
namespace {

using namespace test;
using testing::Contains;
using testing::HasSubstr;

/// The sun at an hour angle, declination and latitude, all degrees: along which it shines, Y up.
vec3 sunlight(float hour, float declination, float latitude)
{
    const float h = glm::radians(hour);
    const float d = glm::radians(declination);
    const float l = glm::radians(latitude);
    return -vec3(-std::cos(d) * std::sin(h), std::sin(l) * std::sin(d) + std::cos(l) * std::cos(d) * std::cos(h),
                 std::sin(l) * std::cos(d) * std::cos(h) - std::cos(l) * std::sin(d));
}

std::vector<vec3> day(float step, float declination = 10.0f)
{
    std::vector<vec3> directions;
    for (float hour = -75.0f; hour <= 75.01f; hour += step) directions.push_back(sunlight(hour, declination, 50.0f));
    return directions;
}

vec3 blend(const std::vector<vec3>& directions, const std::vector<float>& weights)
{
    vec3 sum(0.0f);
    for (std::size_t i = 0; i < weights.size(); ++i) sum += weights[i] * directions[i];
    return sum;
}

float largestChange(const std::vector<float>& a, const std::vector<float>& b)
{
    float most = 0.0f;
    for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, std::abs(a[i] - b[i]));
    return most;
}

TEST(TurningLightsS34, ADirectionOfTheBakeIsItself)
{
    std::vector<vec3> grid; // two seasons
    for (const float declination : {-20.0f, 0.0f, 20.0f})
        for (float hour = -30.0f; hour <= 31.0f; hour += 20.0f) grid.push_back(sunlight(hour, declination, 40.0f));
    for (const std::vector<vec3>& directions : {day(15.0f), day(30.0f), day(14.0f, 0.0f), grid})
        for (std::size_t k = 0; k < directions.size(); ++k) {
            std::vector<float> alone(directions.size(), 0.0f);
            alone[k] = 1.0f;
            EXPECT_LT(largestChange(weightsOfDirections(directions, directions[k]), alone), 1e-4f) << k;
        }
}

/// In steps of a tenth of a degree.
TEST(TurningLightsS34, WeightsOfADayAreContinuousAndAddUpToTheDirection)
{
    for (const float declination : {-23.4f, 0.0f, 10.0f, 23.4f}) {
        const std::vector<vec3> directions = day(15.0f, declination);
        std::vector<float> before = weightsOfDirections(directions, directions[0]);
        for (float hour = -75.0f; hour < 75.0f; hour += 0.1f) {
            const vec3 truth = sunlight(hour, declination, 50.0f);
            const std::vector<float> weights = weightsOfDirections(directions, truth);
            EXPECT_GE(*std::ranges::min_element(weights), 0.0f);
            EXPECT_LE(std::ranges::count_if(weights, [](float w) { return w > 0.0f; }), 3);
            EXPECT_LT(glm::distance(blend(directions, weights), truth), 0.006f) << hour;
            const float sum = std::accumulate(weights.begin(), weights.end(), 0.0f);
            EXPECT_NEAR(sum, 1.0f, 0.011f) << "1 / cos(7.5 degrees) = 1.0086 in the middle";
            // A degree is 1/15 of the way from one direction to the next.
            EXPECT_LT(largestChange(weights, before), 0.01f) << hour;
            before = weights;
        }
    }
}

/// Directions of a day lie on one circle: another noon is no sum of morning and evening.
TEST(TurningLightsS34, BesideADayTheNearestDirectionsCount)
{
    const std::vector<vec3> directions = day(15.0f);
    for (const float declination : {0.0f, 5.0f, 15.0f, 20.0f})
        for (float hour = -30.0f; hour <= 30.0f; hour += 2.5f) {
            const vec3 truth = sunlight(hour, declination, 50.0f);
            const std::vector<float> weights = weightsOfDirections(directions, truth);
            for (std::size_t i = 0; i < weights.size(); ++i)
                if (weights[i] > 1e-4f) {
                    EXPECT_GT(glm::dot(directions[i], truth), std::cos(glm::radians(32.0f)))
                        << declination << " " << hour;
                }
            EXPECT_NEAR(std::accumulate(weights.begin(), weights.end(), 0.0f), 1.0f, 0.03f);
        }
}

/// Of directions all around the zenith.
TEST(TurningLightsS34, AnyDirectionBetweenOthersIsTheirSum)
{
    std::vector<vec3> directions;
    for (int i = 0; i < 12; ++i) { // a spiral around straight down
        const float angle = 2.399963f * float(i);
        const float radius = 0.6f * std::sqrt(float(i) / 11.0f);
        directions.push_back(glm::normalize(vec3(radius * std::cos(angle), -1.0f, radius * std::sin(angle))));
    }
    std::mt19937 random(1);
    std::uniform_real_distribution<float> uniform(-0.2f, 0.2f);
    for (int i = 0; i < 2000; ++i) {
        const vec3 truth = glm::normalize(vec3(uniform(random), -1.0f, uniform(random)));
        const vec3 near = glm::normalize(truth + 1.0e-4f * vec3(uniform(random), 0, uniform(random)));
        const std::vector<float> weights = weightsOfDirections(directions, truth);
        EXPECT_GE(*std::ranges::min_element(weights), 0.0f);
        EXPECT_LT(glm::distance(blend(directions, weights), truth), 0.012f);
        EXPECT_NEAR(std::accumulate(weights.begin(), weights.end(), 0.0f), 1.0f, 0.04f);
        EXPECT_LT(largestChange(weights, weightsOfDirections(directions, near)), 0.003f) << "continuous";
    }
}

TEST(TurningLightsS34, BeyondAllDirectionsLightFadesByTheCosineAndIsNeverNothing)
{
    const std::vector<vec3> directions = {vec3(0, -1, 0), glm::normalize(vec3(0.3f, -1, 0))};
    const auto at = [&](float degrees) {
        return weightsOfDirections(directions,
                                   vec3(-std::sin(glm::radians(degrees)), -std::cos(glm::radians(degrees)), 0));
    };
    EXPECT_NEAR(at(30.0f)[0], std::cos(glm::radians(30.0f)), 0.02f);
    EXPECT_NEAR(at(60.0f)[0], 0.5f, 0.06f);
    EXPECT_EQ(at(60.0f)[1], 0.0f);
    for (const float degrees : {90.0f, 120.0f, 180.0f}) {
        EXPECT_GT(at(degrees)[0] + at(degrees)[1], 0.0f) << "the weights say the light's colour";
        EXPECT_LT(at(degrees)[0] + at(degrees)[1], 1e-5f);
    }
}

TEST(TurningLightsS34, TheLargestStepIsOfTheWayThroughAll)
{
    EXPECT_NEAR(glm::degrees(largestStep(day(15.0f, 0.0f))), 15.0f, 0.01f);
    EXPECT_NEAR(glm::degrees(largestStep(day(25.0f, 0.0f))), 25.0f, 0.01f);
    std::vector<vec3> gap; // each has a near one
    for (const float hour : {-45.0f, -35.0f, 5.0f, 15.0f}) gap.push_back(sunlight(hour, 0.0f, 50.0f));
    EXPECT_NEAR(glm::degrees(largestStep(gap)), 40.0f, 0.01f);
    EXPECT_EQ(largestStep(std::vector{vec3(0, -1, 0)}), 0.0f);
}

/// A directional light whose node has those extras.
GltfBuilder sunWith(const Json& extras, const char* type = "directional")
{
    GltfBuilder file;
    file.triangle();
    file.json["extensionsUsed"] = {"KHR_lights_punctual"};
    file.json["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", type}, {"name", "Sun"}, {"intensity", 3}}};
    file.json["scenes"][0]["nodes"] = {0, 1};
    file.json["nodes"] = {
        {{"mesh", 0}},
        {{"name", "Sun"}, {"extras", extras}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}}};
    return file;
}

TEST(TurningLightsS34, AuthorsGiveDirectionsInExtrasOrInASettingsFile)
{
    const TemporaryFolder folder;
    const auto scene = readScene(sunWith({{"halflight_directions", {{0, -2, 0}, {0, 0, -1}}}}).write(folder));
    ASSERT_TRUE(scene) << scene.error().text();
    EXPECT_EQ(scene->lights.at(0).directions, (std::vector{vec3(0, -1, 0), vec3(0, 0, -1)}));
    const auto flat = readScene(sunWith({{"halflight_directions", {0, -1, 0, 0, 0, -1}}}).write(folder));
    ASSERT_TRUE(flat) << "as Blender writes lists";
    EXPECT_EQ(flat->lights.at(0).directions.size(), 2u);
    writeText(folder / "s.toml", "[[light]]\npattern = \"Sun\"\ndirections = [[1, -1, 0], [0, -1, 0], [-1, -1, 0]]\n");
    ReadOptions options;
    options.settingsFile = folder / "s.toml";
    EXPECT_EQ(readScene(sunWith({}).write(folder), options)->lights.at(0).directions.size(), 3u);
    const auto lamp = readScene(sunWith({{"halflight_directions", {{0, -1, 0}}}}, "point").write(folder));
    EXPECT_TRUE(lamp->lights.at(0).directions.empty());
    EXPECT_THAT(lamp->warnings,
                Contains(HasSubstr("light Sun is no directional light, so its directions have no effect")));
}

TEST(TurningLightsS34, BadDirectionsAreRefused)
{
    Json many = Json::array();
    for (int i = 0; i < 13; ++i) many.push_back({i - 6, -10, 0});
    for (const Json& bad : {Json(3), Json("east"), Json::array({{0, 0, 0}}), Json::array({{0, 1}}), many,
                            Json::array({{0, -1, 0}, {0.001, -1, 0}})}) {
        const TemporaryFolder folder;
        const auto scene = readScene(sunWith({{"halflight_directions", bad}}).write(folder));
        ASSERT_FALSE(scene) << bad;
        EXPECT_THAT(scene.error().text(), HasSubstr("halflight_directions must be a list of at most 12 directions"));
    }
}

Light sunOf(std::vector<vec3> directions)
{
    Light light;
    light.name = "Sun";
    light.type = LightType::Directional;
    light.color = vec3(1, 0.5f, 0);
    light.intensity = 200.0f;
    light.worldFromLight = glm::mat4_cast(glm::rotation(vec3(0, 0, -1), directions.front()));
    light.directions = std::move(directions);
    return light;
}

TEST(TurningLightsS34, EachDirectionIsAGroupOfAWhiteLightWhileTheBakeRuns)
{
    Scene scene;
    scene.lights = {sunOf(day(15.0f, 0.0f)), sunOf(day(50.0f, 0.0f))};
    scene.lights[1].group = "day";
    const std::size_t count = scene.lights[0].directions.size();
    const Scene before = scene;
    auto grouping = groupLights(scene, GroupChoice::Authored);
    ASSERT_TRUE(grouping) << grouping.error().text();
    ASSERT_EQ(grouping->groups.size(), count + 4);
    EXPECT_EQ(grouping->groups[0].name, "Sun.1");
    EXPECT_EQ(grouping->groups[count - 1].name, "Sun.11");
    EXPECT_EQ(grouping->groups[count].name, "Sun 2.1") << "another light of that name";
    EXPECT_THAT(scene.warnings, Contains(HasSubstr("no member of the light group \"day\"")));
    EXPECT_THAT(scene.warnings, Contains(HasSubstr("light \"Sun\" are up to 50 degrees apart")));
    EXPECT_NEAR(grouping->groups[0].weight.y, 0.5f, 1e-4f) << "it shines along the first";
    EXPECT_NEAR(grouping->groups[1].weight.x, 0.0f, 1e-4f);
    grouping->exchange(scene);
    grouping->spread(scene);
    ASSERT_EQ(scene.lights.size(), count + 4);
    for (std::size_t i = 0; i < count; ++i) {
        const Light& light = scene.lights[i == 0 ? 0 : i + 1];
        EXPECT_LT(glm::distance(light.direction(), before.lights[0].directions[i]), 1e-5f);
        EXPECT_EQ(light.color * light.intensity, vec3(200)) << "white, in the channel that is black too";
        EXPECT_EQ(grouping->ofLight[i == 0 ? 0 : i + 1], int(i));
    }
    grouping->gather(scene);
    grouping->exchange(scene);
    ASSERT_EQ(scene.lights.size(), 2u);
    EXPECT_EQ(scene.lights[0].color, before.lights[0].color);
    EXPECT_EQ(scene.lights[0].worldFromLight, before.lights[0].worldFromLight);
    EXPECT_EQ(grouping->ofLight, (std::vector<int>{-1, -1}));
    EXPECT_TRUE(groupLights(scene, GroupChoice::Off)->groups.empty());
}

TEST(TurningLightsS34, DirectionsThatCannotCountAreNamed)
{
    const auto warningsOf = [](LightMode mode, MixedLightingMode mixing) {
        Scene scene;
        scene.lights = {sunOf(day(15.0f))};
        scene.lights[0].mode = mode;
        const auto grouping = groupLights(scene, GroupChoice::Authored, mixing);
        EXPECT_TRUE(grouping && grouping->turning.empty());
        return scene.warnings;
    };
    using testing::ElementsAre;
    EXPECT_THAT(warningsOf(LightMode::Realtime, MixedLightingMode::Shadowmask),
                ElementsAre(HasSubstr(
                    "light Sun is realtime, so that its halflight_directions have no effect: make it mixed")));
    EXPECT_THAT(warningsOf(LightMode::Baked, MixedLightingMode::Shadowmask),
                ElementsAre(HasSubstr("light Sun is baked, so that")));
    EXPECT_THAT(warningsOf(LightMode::Mixed, MixedLightingMode::Subtractive),
                ElementsAre(HasSubstr("bake with --mode shadowmask or baked-indirect")));
    Scene scene;
    scene.lights = {sunOf(day(15.0f)), sunOf(day(15.0f))};
    const auto tooMany = groupLights(scene, GroupChoice::Authored);
    ASSERT_FALSE(tooMany);
    EXPECT_THAT(tooMany.error().text(), HasSubstr("has 22 light groups, and a bake has at most 16"));
}

TEST(TurningLightsS34, FilesWithBadDirectionsAreRefused)
{
    const auto refusal = [](const Json& turns) {
        const TemporaryFolder folder;
        GltfBuilder file = sunWith({});
        file.json["extensionsUsed"] = {"KHR_lights_punctual", "HALFLIGHT_mixed_lighting", "HALFLIGHT_light"};
        file.json["extensions"]["HALFLIGHT_mixed_lighting"] = {
            {"version", 3}, {"mode", "shadowmask"}, {"groups", Json::array()}};
        for (const char* name : {"Sun.1", "Sun.2"})
            file.json["extensions"]["HALFLIGHT_mixed_lighting"]["groups"].push_back(
                {{"name", name}, {"weight", {1, 1, 1}}});
        const std::vector<float> pose = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
        file.json["nodes"][1]["extensions"]["HALFLIGHT_light"] = {{"mode", "mixed"},
                                                                  {"shadowStrength", 1},
                                                                  {"indirectMultiplier", 1},
                                                                  {"castShadows", true},
                                                                  {"radius", 0},
                                                                  {"baking",
                                                                   {{"bakeType", "mixed"},
                                                                    {"mixedLightingMode", "shadowmask"},
                                                                    {"occlusionMaskChannel", -1},
                                                                    {"white", {3, 3, 3}},
                                                                    {"worldFromLight", pose},
                                                                    {"turns", turns}}}};
        const auto baked = readBakedScene(file.write(folder));
        return baked ? std::string("read") : baked.error().text();
    };
    const Json two = Json::array({{0, -1, 0}, {0, 0, -1}});
    EXPECT_EQ(refusal({{"group", 0}, {"directions", two}}), "read");
    EXPECT_THAT(refusal({{"group", 1}, {"directions", two}}), HasSubstr("turns by light groups that the file lacks"));
    EXPECT_THAT(refusal({{"group", 0}}), HasSubstr("turns by light groups that the file lacks"));
    EXPECT_THAT(refusal({{"group", 0}, {"directions", {{0, -1, 0}, {0, 0, 0}}}}), HasSubstr("unit vectors"));
    EXPECT_THAT(refusal({{"group", 0}, {"directions", "east"}}), HasSubstr("directions"));
    EXPECT_THAT(refusal({{"group", -3}, {"directions", two}}), HasSubstr("group"));
}

} // namespace
} // namespace halflight::turning_lights_test
