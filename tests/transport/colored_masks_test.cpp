// Masks and probes behind coloured glass, against closed forms (spec S35).
#include "transport/colored_bench.h"

#include <gtest/gtest.h>

#include <array>
#include <string>
#include <utility>

namespace halflight::test::colored_masks_test {
namespace {

using namespace glass;

std::string nameOfGlass(const testing::TestParamInfo<Glass>& info)
{
    constexpr std::array<const char*, 4> kNames = {"Quad", "Pane", "Box", "Thin"};
    return kNames[std::size_t(info.param)];
}
class ColoredMasksS35 : public testing::TestWithParam<Glass> {};
INSTANTIATE_TEST_SUITE_P(Transport, ColoredMasksS35, testing::Values(Glass::Quad, Glass::Pane, Glass::Box, Glass::Thin),
                         nameOfGlass);

TEST_P(ColoredMasksS35, MaskIsTheClosedForm)
{
    for (const MixedLightingMode mode : {MixedLightingMode::Shadowmask, MixedLightingMode::Subtractive}) {
        Scene scene = floorUnderSun();
        addGlass(scene, GetParam());
        ColoredBench bench(std::move(scene), mode);
        EXPECT_EQ(bench.shares[0], 1.0f);
        EXPECT_TRUE(bench.scene.lights[0].baking.coloredMask);
        for (const vec4& mask : bench.shadowmask()) {
            expectColor(vec3(mask), expectedOf(GetParam(), -kSlanted.y));
            EXPECT_EQ(mask.w, 1.0f) << "no light has the fourth channel";
        }
    }
}

TEST_P(ColoredMasksS35, ProbesHoldItToo)
{
    Scene scene = floorUnderSun();
    addGlass(scene, GetParam());
    ColoredBench bench(std::move(scene), MixedLightingMode::Shadowmask);
    const std::vector<vec3> places = {vec3(0, 0.25f, 0), vec3(0.1f, kHeight + 1.0f, 0)};
    const std::vector<uint32_t> which = {0, 1};
    std::vector<ProbeEstimate> out(2);
    ASSERT_TRUE(bench.integrator->probes(places, which, 64, out, {}));
    expectColor(vec3(out[0].occlusion.layers[0]), expectedOf(GetParam(), -kSlanted.y));
    EXPECT_EQ(vec3(out[1].occlusion.layers[0]), vec3(1.0f)) << "above the glass";
    EXPECT_EQ(out[0].occlusion[3], 1.0f);
}

/// Half of the floor lies under a small pane, the other half under nothing or a wall: there the mask is grey.
TEST(ColoredMaskEdgesS35, LitAndShadowedPlacesHaveNoColor)
{
    Scene scene = floorUnderSun();
    scene.lights[0].worldFromLight = lightPose(vec3(0), vec3(1.0e-3f, -1, 0));
    const int pane = addGlassMaterial(scene, Glass::Quad);
    const int wall = addMaterial(scene, vec3(0.0f));
    addRectangle(scene, {vec3(-1, 0.5f, 1), vec3(1, 0, 0), vec3(0, 0, -2)}, pane, kPage);
    addRectangle(scene, {vec3(0.25f, 0.5f, 1), vec3(1, 0, 0), vec3(0, 0, -2)}, wall, kPage);
    ColoredBench bench(std::move(scene), MixedLightingMode::Shadowmask);
    EXPECT_NEAR(bench.shares[0], 0.5f, 0.1f);
    const std::vector<vec4> masks = bench.shadowmask();
    for (std::size_t i = 0; i < masks.size(); ++i) {
        const float x = bench.positionOf(bench.map.texels[i]).x;
        constexpr float kTexel = 0.125f;
        if (std::abs(x) < kTexel || std::abs(x - 0.25f) < kTexel) continue;
        if (x < 0.0f)
            expectColor(vec3(masks[i]), expectedOf(Glass::Quad, 1.0f));
        else
            EXPECT_EQ(vec3(masks[i]), vec3(x < 0.25f ? 1.0f : 0.0f)) << x;
    }
}

TEST(ColoredShadowsS35, GreyGlassHasNoShare)
{
    for (const bool any : {false, true}) {
        Scene scene = floorUnderSun();
        if (any) {
            addGlass(scene, Glass::Quad);
            scene.materials.back().baseColor = vec4(0.5f, 0.5f, 0.5f, kAlpha);
        }
        Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, oneSample());
        std::vector<float> shares(1, 7.0f);
        const uint64_t before = bench.integrator->raysTraced();
        ASSERT_TRUE(bench.integrator->coloredShadows(bench.map, shares, {}));
        EXPECT_EQ(shares[0], 0.0f);
        if (!any) EXPECT_EQ(bench.integrator->raysTraced(), before) << "nothing is traced where no glass is";
    }
}

/// A grey light in a channel of a coloured one, out of its reach, keeps its own mask; and the coloured one all three.
TEST(ColoredShadowsS35, LightsOutOfReachShareChannels)
{
    Scene scene;
    const int black = addMaterial(scene, vec3(0.0f));
    const int pane = addGlassMaterial(scene, Glass::Quad);
    for (const float x : {-10.0f, 10.0f}) {
        addRectangle(scene, {vec3(x - 0.5f, 0, 0.5f), vec3(1, 0, 0), vec3(0, 0, -1)}, black, kPage,
                     x < 0.0f ? Place{vec2(1), vec2(7)} : Place{vec2(9), vec2(15)});
        Light lamp = makeLight(LightType::Point, vec3(x, 2, 0), vec3(0, -1, 0), 10.0f, LightMode::Mixed);
        lamp.rangeMeters = 5.0f;
        scene.lights.push_back(lamp);
    }
    addRectangle(scene, {vec3(-12, 1, 2), vec3(4, 0, 0), vec3(0, 0, -4)}, pane, kPage);
    const int board = addMaterial(scene, vec3(0.0f), vec3(0.0f), true);
    addRectangle(scene, {vec3(8, 1, 2), vec3(4, 0, 0), vec3(0, 0, -4)}, board, kPage);
    ColoredBench bench(std::move(scene), MixedLightingMode::Shadowmask);
    ASSERT_TRUE(bench.scene.lights[0].baking.coloredMask);
    ASSERT_FALSE(bench.scene.lights[1].baking.coloredMask);
    ASSERT_EQ(bench.scene.lights[1].baking.occlusionMaskChannel, 0);
    const std::vector<vec4> masks = bench.shadowmask();
    for (std::size_t i = 0; i < masks.size(); ++i) {
        if (bench.positionOf(bench.map.texels[i]).x < 0.0f)
            expectColor(vec3(masks[i]), expectedOf(Glass::Quad, 1.0f));
        else
            EXPECT_EQ(masks[i], vec4(0, 1, 1, 1)) << "in the board's shadow";
    }
}

} // namespace
} // namespace halflight::test::colored_masks_test
