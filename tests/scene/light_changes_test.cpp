// S29. A change of a baked or mixed light that shows nowhere, or only in part, is said, with what to do about it.
#include "halflight/scene/scene.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

namespace halflight::light_changes_test {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

enum class Kind { Mixed, Subtractive, Baked, Overflowed, Realtime };

/// A light as a bake leaves it.
Light bakedAs(Kind kind, LightType type = LightType::Spot)
{
    Light light;
    light.name = "lamp";
    light.type = type;
    light.color = vec3(1.0f, 0.8f, 0.5f);
    light.intensity = 100.0f;
    light.rangeMeters = type == LightType::Directional ? 0.0f : 5.0f;
    light.innerConeRadians = 0.2f;
    light.outerConeRadians = 0.5f;
    light.mode = kind == Kind::Baked      ? LightMode::Baked
                 : kind == Kind::Realtime ? LightMode::Realtime
                                          : LightMode::Mixed;
    BakingOutput& baking = light.baking;
    baking.isBaked = kind != Kind::Realtime;
    baking.bakeType = kind == Kind::Overflowed ? LightMode::Baked : light.mode;
    baking.mixedMode = kind == Kind::Subtractive ? MixedLightingMode::Subtractive : MixedLightingMode::Shadowmask;
    baking.occlusionMaskChannel = kind == Kind::Mixed ? 0 : -1;
    baking.worldFromLight = light.worldFromLight;
    baking.reachMeters = light.rangeMeters;
    baking.outerConeRadians = light.outerConeRadians;
    baking.atBake = lightAtBake(light);
    return light;
}

std::vector<std::string> sayAfter(Light light, const std::function<void(Light&)>& change)
{
    change(light);
    return changesSinceBake(light, "light \"lamp\"", true);
}

constexpr Kind kKinds[] = {Kind::Mixed, Kind::Subtractive, Kind::Baked, Kind::Overflowed, Kind::Realtime};
constexpr LightType kTypes[] = {LightType::Directional, LightType::Point, LightType::Spot};

TEST(LightChangesS29, NothingIsSaidOfALightInStep)
{
    for (const Kind kind : kKinds) {
        for (const LightType type : kTypes) EXPECT_THAT(sayAfter(bakedAs(kind, type), [](Light&) {}), IsEmpty());
    }
}

TEST(LightChangesS29, RealtimeLightsMayDoAsTheyLike)
{
    const auto all = [](Light& light) {
        light.color = vec3(0.0f, 0.0f, 1.0f);
        light.intensity = 1.0e6f;
        light.rangeMeters = 0.0f;
        light.outerConeRadians = 1.5f;
        light.worldFromLight[3].x = 7.0f;
    };
    EXPECT_THAT(sayAfter(bakedAs(Kind::Realtime), all), IsEmpty());
}

TEST(LightChangesS29, NoChangeOfAFullyBakedLightHasAnEffect)
{
    const std::pair<const char*, std::function<void(Light&)>> changes[] = {
        {"colour or intensity", [](Light& light) { light.intensity *= 1.01f; }},
        {"colour or intensity", [](Light& light) { light.color.b = 0.0f; }},
        {"range", [](Light& light) { light.rangeMeters = 3.0f; }},
        {"range", [](Light& light) { light.rangeMeters = 0.0f; }},
        {"cone", [](Light& light) { light.outerConeRadians = 0.6f; }},
        {"cone", [](Light& light) { light.innerConeRadians = 0.1f; }},
        {"shadow switch", [](Light& light) { light.castShadows = false; }},
        {"shadow strength", [](Light& light) { light.shadowStrength = 0.5f; }},
    };
    for (const auto& [what, change] : changes) {
        EXPECT_THAT(sayAfter(bakedAs(Kind::Baked), change),
                    ElementsAre(AllOf(HasSubstr("light \"lamp\""), HasSubstr(std::string("(") + what + ")"),
                                      HasSubstr("no effect"), HasSubstr("as a mixed light"))));
        EXPECT_THAT(sayAfter(bakedAs(Kind::Overflowed), change),
                    ElementsAre(AllOf(HasSubstr("no effect"), HasSubstr("no shadowmask channel was left"))));
        EXPECT_THAT(sayAfter(bakedAs(Kind::Subtractive), change),
                    ElementsAre(AllOf(HasSubstr(what), HasSubstr("static objects"), HasSubstr("shadowmask mode"))));
    }
}

TEST(LightChangesS29, ColorThatKeepsTheProductIsNoChange)
{
    const auto rescale = [](Light& light) {
        light.color *= 0.25f;
        light.intensity *= 4.0f;
    };
    for (const Kind kind : kKinds) EXPECT_THAT(sayAfter(bakedAs(kind), rescale), IsEmpty());
}

// Bounced light stays: said from a factor of four in luminance on, up and down, and for lights turned off or on.
TEST(LightChangesS29, BouncedLightOfMixedLightsStays)
{
    const auto by = [](float factor) { return [factor](Light& light) { light.intensity *= factor; }; };
    for (const float small : {0.26f, 0.9f, 1.5f, 3.9f})
        EXPECT_THAT(sayAfter(bakedAs(Kind::Mixed), by(small)), IsEmpty());
    EXPECT_THAT(sayAfter(bakedAs(Kind::Mixed), by(8.0f)),
                ElementsAre(AllOf(HasSubstr("brighter by a factor of 8 "), HasSubstr("bounced light stays"),
                                  HasSubstr("indirect multiplier of 0"))));
    EXPECT_THAT(sayAfter(bakedAs(Kind::Mixed), by(0.1f)), ElementsAre(HasSubstr("dimmer by a factor of 10 ")));
    EXPECT_THAT(sayAfter(bakedAs(Kind::Mixed), by(0.0f)), ElementsAre(HasSubstr("was turned off after the bake")));
    // Luminance counts, not the sum of the channels: blue brings 7 % of white's.
    const auto blue = [](Light& light) { light.color = vec3(0.0f, 0.0f, 1.0f); };
    EXPECT_THAT(sayAfter(bakedAs(Kind::Mixed), blue), ElementsAre(HasSubstr("dimmer by a factor of ")));
    Light dark = bakedAs(Kind::Mixed);
    dark.intensity = 0.0f;
    dark.baking.atBake = lightAtBake(dark);
    EXPECT_THAT(sayAfter(dark, [](Light& light) { light.intensity = 1.0f; }),
                ElementsAre(HasSubstr("dark at its bake")));
    Light unbounced = bakedAs(Kind::Mixed);
    unbounced.baking.atBake.indirectMultiplier = 0.0f;
    EXPECT_THAT(sayAfter(unbounced, by(100.0f)), IsEmpty()) << "the cure itself";
}

TEST(LightChangesS29, AGrownReachIsSaidAndAShrunkenOneIsNot)
{
    EXPECT_THAT(sayAfter(bakedAs(Kind::Mixed), [](Light& light) { light.rangeMeters = 20.0f; }),
                ElementsAre(AllOf(HasSubstr("is 20 m, and was 5 m"), HasSubstr("no baked shadow"))));
    EXPECT_THAT(sayAfter(bakedAs(Kind::Mixed), [](Light& light) { light.rangeMeters = 0.0f; }),
                ElementsAre(HasSubstr("is unlimited, and was 5 m")));
    EXPECT_THAT(sayAfter(bakedAs(Kind::Mixed), [](Light& light) { light.rangeMeters = 4.0f; }), IsEmpty());
    EXPECT_THAT(sayAfter(bakedAs(Kind::Mixed), [](Light& light) { light.outerConeRadians = glm::radians(60.0f); }),
                ElementsAre(HasSubstr("cone of light \"lamp\" is 60 degrees, and was 28.65 degrees")));
    EXPECT_THAT(sayAfter(bakedAs(Kind::Mixed), [](Light& light) { light.outerConeRadians = 0.3f; }), IsEmpty());
    EXPECT_THAT(sayAfter(bakedAs(Kind::Mixed, LightType::Point), [](Light& light) { light.outerConeRadians = 1.5f; }),
                IsEmpty())
        << "point lights have no cone";
    Light unlimited = bakedAs(Kind::Mixed, LightType::Point);
    unlimited.rangeMeters = 0.0f;
    unlimited.baking.reachMeters = 12.0f; // what the bake gave it
    unlimited.baking.atBake = lightAtBake(unlimited);
    EXPECT_THAT(sayAfter(unlimited, [](Light&) {}), IsEmpty());
}

TEST(LightChangesS29, FilesThatRecordedNothingSayNothing)
{
    for (const Kind kind : {Kind::Mixed, Kind::Subtractive, Kind::Baked}) {
        Light light = bakedAs(kind);
        light.baking.atBake = {};
        EXPECT_THAT(sayAfter(light, [](Light& l) { l.intensity *= 50.0f; }), IsEmpty());
        EXPECT_THAT(sayAfter(light, [](Light& l) { l.worldFromLight[3].x = 1.0f; }),
                    ElementsAre(HasSubstr("was moved")));
    }
}

} // namespace
} // namespace halflight::light_changes_test
