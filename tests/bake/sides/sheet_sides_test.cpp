// Which sides of double-sided sheets get texels (spec S6), and what texels hold that both sides share (spec S6, S8).

#include "bake/lights/channels.h"
#include "bake/sides/sheet_sides.h"
#include "bake/test_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace halflight::test::sheet_sides_test {
namespace {

constexpr double kTexel = 0.05; // metres
const vec3 kGrey(0.5f);

/// A floor of 8 x 8 metres, of one side, under a sky from white at the zenith to black at the horizon.
Scene floorUnderSky()
{
    Scene scene;
    scene.sky = {vec3(1.0f), vec3(0.2f), vec3(0.0f)};
    addRectangle(scene, {vec3(-4, 0, 4), vec3(8, 0, 0), vec3(0, 0, -8)}, addMaterial(scene, kGrey), 64);
    return scene;
}

/// The decision for the scene's last object.
std::vector<SheetTexels> texelsOfLast(Scene scene, TwoSided mode = TwoSided::Automatic, uint32_t seed = 1)
{
    assignShadowmaskChannels(scene, MixedLightingMode::Shadowmask);
    IntegrationSettings settings;
    settings.seed = seed;
    const Progress progress;
    const IntegratorFactory factory = embreeIntegrators();
    SourceTree tree(factory, settings);
    return sheetSidesTest(tree, mode, progress)(scene, kTexel)[std::size_t(scene.objects.back().mesh)];
}

struct SheetCase {
    const char* what;
    SheetTexels right;
    std::function<void(Scene&, int sheet)> add; ///< the sheet's material is double-sided
};

const Rectangle kUpright{vec3(-1, 0.5f, 0), vec3(2, 0, 0), vec3(0, 1, 0)};
const Rectangle kLevel{vec3(-1, 1, 1), vec3(2, 0, 0), vec3(0, 0, -2)};

std::vector<SheetCase> sheetCases()
{
    const auto box = [](Scene& scene, int material, bool inward) {
        const std::size_t first = scene.objects.size();
        addBox(scene, vec3(-1, 0.1f, -1), vec3(1, 1.6f, 1), material, inward);
        joinObjects(scene, first);
    };
    const auto lampIn = [](Scene& scene) { scene.lights.push_back(pointAt("lamp", vec3(0, 1, 0), 5.0f)); };
    return {
        {"a level board under the sky", SheetTexels::Both, [](Scene& s, int m) { addRectangle(s, kLevel, m, 64); }},
        {"an upright board, lit alike on both sides", SheetTexels::Mean,
         [](Scene& s, int m) { addRectangle(s, kUpright, m, 64); }},
        {"a leaf of 6 cm", SheetTexels::Mean,
         [](Scene& s, int m) {
             addRectangle(s, {vec3(0, 1, 0), vec3(0.06f, 0, 0), vec3(0, 0, -0.06f)}, m, 64);
         }},
        {"a slat of 10 cm x 14 cm", SheetTexels::Both,
         [](Scene& s, int m) {
             addRectangle(s, {vec3(0, 1, 0), vec3(0.1f, 0, 0), vec3(0, 0, -0.14f)}, m, 64);
         }},
        {"a label that lies a millimetre above the floor", SheetTexels::Front,
         [](Scene& s, int m) {
             addRectangle(s, {vec3(-1, 0.001f, 1), vec3(2, 0, 0), vec3(0, 0, -2)}, m, 64);
         }},
        {"the same face down", SheetTexels::Back,
         [](Scene& s, int m) {
             addRectangle(s, {vec3(-1, 0.001f, 1), vec3(0, 0, -2), vec3(2, 0, 0)}, m, 64);
         }},
        {"ground that is the whole scene", SheetTexels::BothWithEvenBack,
         [](Scene& s, int m) {
             s.objects.clear();
             s.meshes.clear();
             s.sky = {vec3(1.0f), vec3(0.5f), vec3(0.5f)};
             addRectangle(s, {vec3(-4, 0, 4), vec3(8, 0, 0), vec3(0, 0, -8)}, m, 64);
         }},
        {"a solid", SheetTexels::Front, [=](Scene& s, int m) { box(s, m, false); }},
        {"a solid with a lamp in it is a room", SheetTexels::Both,
         [=](Scene& s, int m) {
             box(s, m, false);
             lampIn(s);
         }},
        {"a room with a lamp in it, seen from outside too", SheetTexels::Both,
         [=](Scene& s, int m) {
             box(s, m, true);
             lampIn(s);
         }},
        {"a room with a lamp under a black sky", SheetTexels::BothWithEvenBack,
         [=](Scene& s, int m) {
             s.objects.clear();
             s.meshes.clear();
             s.sky = {};
             box(s, m, true);
             lampIn(s);
         }},
    };
}

TEST(SheetSidesS6, SidesThatAreSeenGetTexels)
{
    for (const SheetCase& sheet : sheetCases()) {
        SCOPED_TRACE(sheet.what);
        for (uint32_t seed = 1; seed <= 4; ++seed) {
            Scene scene = floorUnderSky();
            sheet.add(scene, addMaterial(scene, kGrey, vec3(0.0f), true));
            std::vector<SheetTexels> texels = texelsOfLast(scene, TwoSided::Automatic, seed);
            if (texels.empty()) texels = {SheetTexels::Front};
            for (const SheetTexels t : texels) EXPECT_EQ(int(t), int(sheet.right)) << "seed " << seed;
        }
    }
}

TEST(SheetSidesS6, SettingsDecide)
{
    Scene scene = floorUnderSky();
    addRectangle(scene, kLevel, addMaterial(scene, kGrey, vec3(0.0f), true), 64);
    EXPECT_EQ(texelsOfLast(scene, TwoSided::Off)[0], SheetTexels::FrontOfBoth);
    scene.objects.back().twoSided = TwoSided::On;
    EXPECT_TRUE(isDoubled(texelsOfLast(scene, TwoSided::Off)[0]));
    Scene alike = floorUnderSky();
    addRectangle(alike, kUpright, addMaterial(alike, kGrey, vec3(0.0f), true), 64);
    EXPECT_TRUE(isDoubled(texelsOfLast(alike, TwoSided::On)[0]));
    Scene single = floorUnderSky();
    addRectangle(single, kLevel, addMaterial(single, kGrey), 64);
    EXPECT_TRUE(texelsOfLast(single, TwoSided::On).empty());
}

/// A board under a sky. Radiance of the sky above goes from 0.5 at the horizon to 1.25, with the sine of the elevation:
/// irradiance is pi (0.5 + 0.75 * 2 / 3) on the upper side, and pi / 2 on the lower one.
Scene boardBetweenSkies(std::vector<TexelSide> sides)
{
    Scene scene;
    scene.sky = {vec3(1.25f), vec3(0.5f), vec3(0.5f)};
    addRectangle(scene, {vec3(-1, 0, 1), vec3(2, 0, 0), vec3(0, 0, -2)}, addMaterial(scene, kGrey, vec3(0.0f), true),
                 64, {vec2(4), vec2(36)});
    scene.meshes[0].parts[0].texelSides = std::move(sides);
    return scene;
}

TEST(SheetSidesS6, TexelsHoldTheLightOfTheirSides)
{
    const struct {
        TexelSide side;
        float right;
    } cases[] = {{TexelSide::Front, kPi},
                 {TexelSide::FrontOfBoth, kPi},
                 {TexelSide::Mean, 0.75f * kPi},
                 {TexelSide::Back, 0.5f * kPi}};
    for (const IntegratorKind kind : {IntegratorKind::Cache, IntegratorKind::Path}) {
        for (const auto& c : cases) {
            IntegrationSettings settings;
            settings.integrator = kind;
            settings.samples = 64;
            Bench bench(boardBetweenSkies({c.side, c.side}), MixedLightingMode::Shadowmask, 64, settings);
            double sum = 0.0;
            const auto estimates = bench.irradiance();
            for (const IrradianceEstimate& e : estimates) sum += double(luminance(e.irradiance));
            EXPECT_NEAR(sum / double(estimates.size()) / double(c.right), 1.0, 0.01) << int(c.side);
        }
    }
}

/// A light above or below the board: its mask is 1 on sheets whose sides share texels, and baked light is the mean.
TEST(SheetSidesS8, MaskRaysStartOnTheSideThatFacesTheLight)
{
    for (const float height : {-2.0f, 2.0f}) {
        for (const TexelSide side : {TexelSide::Front, TexelSide::FrontOfBoth, TexelSide::Mean}) {
            Scene scene = boardBetweenSkies({side, side});
            scene.sky = {};
            scene.lights.push_back(makeLight(LightType::Directional, vec3(0, height, 0), vec3(1, -height, 0),
                                             std::sqrt(5.0f), LightMode::Mixed));
            Bench mixed(scene, MixedLightingMode::Shadowmask, 64, {.samples = 16, .bounces = 0});
            const float lit = height > 0.0f || side != TexelSide::Front ? 1.0f : 0.0f;
            for (const vec4 mask : mixed.shadowmask()) EXPECT_EQ(mask.x, lit);
            scene.lights[0].mode = LightMode::Baked;
            Bench baked(scene, MixedLightingMode::Shadowmask, 64, {.samples = 16, .bounces = 0});
            const float right = side == TexelSide::Mean ? 1.0f : height > 0.0f ? 2.0f : 0.0f;
            for (const IrradianceEstimate& e : baked.irradiance()) EXPECT_NEAR(e.irradiance.x, right, 1e-3f);
        }
    }
}

} // namespace
} // namespace halflight::test::sheet_sides_test
