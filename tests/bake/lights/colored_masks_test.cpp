// S35. Channels of lights with coloured masks, what the bake makes of them, and how it names those that stay grey.
#include "bake/lights/channels.h"
#include "bake/lights/colored_masks.h"
#include "bake/lights/group_states.h"

#include "halflight/shading/mask.h"

#include <gmock/gmock.h>

namespace halflight::test::colored_masks_test {
namespace {

using testing::HasSubstr;

/// Suns of decreasing brightness, all of which overlap.
Scene suns(int count)
{
    Scene scene;
    for (int i = 0; i < count; ++i) {
        Light sun =
            makeLight(LightType::Directional, vec3(0), vec3(0.1f * float(i), -1, 0), float(100 - i), LightMode::Mixed);
        sun.name = "sun " + std::to_string(i);
        scene.lights.push_back(sun);
    }
    return scene;
}

std::vector<int> channelsOf(const Scene& scene)
{
    std::vector<int> channels;
    for (const Light& light : scene.lights)
        channels.push_back(light.baking.occlusionMaskChannel + (light.baking.coloredMask ? 100 : 0));
    return channels;
}

std::vector<int> channelsAfter(int lights, const std::vector<float>& shares, int layers,
                               std::vector<std::string>* leftGray = nullptr)
{
    Scene scene = suns(lights);
    assignShadowmaskChannels(scene, MixedLightingMode::Shadowmask, layers);
    const ColoredMasks masks = colorMasks(scene, shares, layers);
    if (leftGray != nullptr) *leftGray = masks.leftGray;
    return channelsOf(scene);
}

TEST(ColoredChannelsS35, AColoredLightTakesThreeOfALayer)
{
    // 100: a coloured mask, from that channel on.
    EXPECT_EQ(channelsAfter(2, {0, 0}, 1), (std::vector{0, 1}));
    EXPECT_EQ(channelsAfter(2, {0.0009f, 0}, 1), (std::vector{0, 1})) << "fewer than 0.1 % of the texels";
    EXPECT_EQ(channelsAfter(2, {0.0011f, 0}, 1), (std::vector{100, 3}));
    EXPECT_EQ(channelsAfter(2, {0, 1}, 1), (std::vector{3, 100})) << "the grey one moves";
    EXPECT_EQ(channelsAfter(5, {0, 1, 0, 1, 0}, 4), (std::vector{3, 100, 7, 104, 8}));
    EXPECT_EQ(channelsAfter(4, {1, 1, 1, 1}, 4), (std::vector{100, 104, 108, 112}));
}

TEST(ColoredChannelsS35, WithoutRoomTheMaskIsGreyAndNoLightIsLost)
{
    std::vector<std::string> grey;
    EXPECT_EQ(channelsAfter(3, {1, 0, 0}, 1, &grey), (std::vector{0, 1, 2}))
        << "three channels would leave one for two";
    EXPECT_EQ(grey, (std::vector<std::string>{"sun 0"}));
    EXPECT_EQ(channelsAfter(2, {1, 1}, 1, &grey), (std::vector{100, 3})) << "the brighter one has its colour";
    EXPECT_EQ(grey, (std::vector<std::string>{"sun 1"}));
    EXPECT_EQ(channelsAfter(5, {1, 1, 1, 1, 1}, 4, &grey), (std::vector{100, 104, 108, 112, 3}));
    EXPECT_EQ(grey, (std::vector<std::string>{"sun 4"}));
}

/// Lamps along a street: those that do not overlap share the three channels.
TEST(ColoredChannelsS35, LightsApartShareTheThree)
{
    Scene scene;
    for (int i = 0; i < 40; ++i)
        scene.lights.push_back(pointAt("lamp " + std::to_string(i), vec3(10.0f * float(i), 4, 0), 9.0f, 10.0f));
    assignShadowmaskChannels(scene, MixedLightingMode::Shadowmask, 4);
    EXPECT_EQ(maskLayersOf(scene), 1);
    EXPECT_TRUE(colorMasks(scene, std::vector<float>(40, 1.0f), 4).leftGray.empty());
    EXPECT_EQ(maskLayersOf(scene), 2);
    for (std::size_t i = 0; i < 40; ++i) {
        EXPECT_TRUE(scene.lights[i].baking.coloredMask);
        if (i > 0) EXPECT_NE(channelsOf(scene)[i], channelsOf(scene)[i - 1]);
    }
}

constexpr float kGlassHeight = 1.0f;
const vec3 kPassed(0.8f, 0.4f, 0.2f); // steps of a mask; 1 - alpha times the base colour, below

/// A white floor. Half of it lies under a pane; a wall stands on the other half.
Scene room(int lights)
{
    Scene scene = suns(lights);
    scene.lights[0].worldFromLight = lightPose(vec3(0), vec3(1.0e-3f, -1, 0)); // from above
    const int white = addMaterial(scene, vec3(0.5f));
    const int glass = addMaterial(scene, kPassed);
    Material& pane = scene.materials.back();
    pane.name = "pane";
    pane.alphaMode = Material::AlphaMode::Blend;
    pane.baseColor.w = 0.0f;
    pane.tinted = true;
    addRectangle(scene, {vec3(-4, 0, 4), vec3(8, 0, 0), vec3(0, 0, -8)}, white, 64);
    addRectangle(scene, {vec3(-9, kGlassHeight, 9), vec3(9, 0, 0), vec3(0, 0, -18)}, glass, 64);
    addRectangle(scene, {vec3(2, kGlassHeight, 9), vec3(9, 0, 0), vec3(0, 0, -18)}, white, 64);
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
        scene.objects[i].name = i == 0 ? "floor" : i == 1 ? "glass" : "board";
        scene.objects[i].lightmapScale = i == 0 ? 1.0f : 0.0f;
    }
    return scene;
}

BakeSettings settingsOf(MixedLightingMode mode)
{
    BakeSettings settings;
    settings.mode = mode;
    settings.quality = Quality::Preview;
    settings.samples = 16;
    settings.bounces = 0;
    settings.lightmapSize = 64;
    settings.probeSpacingMeters = 3.0f;
    settings.probeLayout = ProbeLayout::Grid;
    settings.reflectionProbes = false;
    return settings;
}

/// How many of the floor's texels the mask says are of each kind; `other`: edges.
struct Kinds {
    int lit = 0;
    int dark = 0;
    int tinted = 0;
    int other = 0;
};
Kinds kindsOf(const ImageRgba8& mask)
{
    Kinds kinds;
    const ivec3 passed(glm::round(kPassed * 255.0f));
    for (const u8vec4& texel : mask.texels()) {
        const ivec3 difference = glm::abs(ivec3(texel) - passed);
        if (texel == u8vec4(255))
            ++kinds.lit;
        else if (texel == u8vec4(0, 0, 0, 255))
            ++kinds.dark;
        else if (std::max({difference.x, difference.y, difference.z}) <= 1 && texel.a == 255)
            ++kinds.tinted;
        else
            ++kinds.other;
    }
    return kinds;
}

void expectMaskOfRoom(const BakedScene& baked)
{
    ASSERT_EQ(baked.shadowmasks.size(), 1u);
    const Kinds kinds = kindsOf(baked.shadowmasks[0]);
    const int all = int(baked.shadowmasks[0].texelCount());
    EXPECT_GT(kinds.lit, all / 6);
    EXPECT_GT(kinds.dark, all / 6);
    EXPECT_GT(kinds.tinted, all / 3);
    EXPECT_LT(kinds.other, all / 8) << "edges, and the page's rim";
}

TEST(ColoredMaskBakeS35, TheMaskHasTheColorOfTheGlass)
{
    for (const MaskEncoding encoding : {MaskEncoding::Attenuation, MaskEncoding::Distance}) {
        BakeSettings settings = settingsOf(MixedLightingMode::Shadowmask);
        settings.maskEncoding = encoding;
        const BakeResult result = bakeOf(room(1), settings);
        EXPECT_TRUE(result.baked.scene.lights[0].baking.coloredMask);
        EXPECT_TRUE(result.report.lights[0].coloredMask);
        EXPECT_TRUE(result.report.warnings.empty()) << result.report.warnings[0];
        for (int c = 0; c < 3; ++c)
            EXPECT_EQ(result.baked.maskChannels[std::size_t(c)].rangeTexels, 0.0f) << "never as a distance field";
        expectMaskOfRoom(result.baked);
        float least = 1.0f;
        for (const Probe& probe : result.baked.probes.probes) least = std::min(least, probe.occlusion[2]);
        EXPECT_NEAR(least, 0.0f, 0.11f) << "probes hold it by colour, too";
    }
}

TEST(ColoredMaskBakeS35, SubtractiveLightmapAndMaskHaveTheColor)
{
    for (const bool mask : {true, false}) {
        BakeSettings settings = settingsOf(MixedLightingMode::Subtractive);
        settings.subtractiveMask = mask;
        const BakeResult result = bakeOf(room(1), settings);
        EXPECT_TRUE(result.baked.scene.lights[0].baking.coloredMask);
        if (mask) expectMaskOfRoom(result.baked);
        int tinted = 0;
        for (const vec3 light : result.irradiance[0].texels()) {
            const vec3 share = light / 100.0f;
            tinted += glm::all(glm::lessThan(glm::abs(share / kPassed - 1.0f), vec3(0.01f))) ? 1 : 0;
        }
        EXPECT_GT(tinted, int(result.irradiance[0].texelCount()) / 3) << "direct light of the main light";
    }
}

TEST(ColoredMaskBakeS35, LightsThatStayGreyAreNamedWithTheCure)
{
    BakeSettings settings = settingsOf(MixedLightingMode::Shadowmask);
    settings.mostMaskLayers = 1;
    const BakeResult one = bakeOf(room(2), settings);
    ASSERT_EQ(one.report.warnings.size(), 1u);
    EXPECT_THAT(one.report.warnings[0], HasSubstr("\"sun 1\""));
    EXPECT_THAT(one.report.warnings[0], HasSubstr("\"pane\""));
    EXPECT_THAT(one.report.warnings[0], HasSubstr("bake with --mask-layers auto"));
    EXPECT_FALSE(one.baked.scene.lights[1].baking.coloredMask);
    settings.mostMaskLayers = kMostMaskLayers;
    const BakeResult two = bakeOf(room(2), settings);
    EXPECT_TRUE(two.report.warnings.empty());
    EXPECT_EQ(channelsOf(two.baked.scene), (std::vector{100, 104}));
    EXPECT_EQ(two.baked.maskLayers, 2);
    EXPECT_EQ(two.report.lights[1].channel, 4);
}

} // namespace
} // namespace halflight::test::colored_masks_test
