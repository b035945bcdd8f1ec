// Direct light in lightmaps against closed forms (spec S6, S23, S30).

#include "bake/both_integrators.h"
#include "bake/cache/cached_integrator.h"
#include "bake/lights/main_light.h"
#include "bake/pages/encode.h"

#include "halflight/shading/random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

namespace halflight::test::direct_light_test {
namespace {

constexpr int kPage = 64;

class DirectS6 : public BothIntegrators {};
INSTANTIATE_TEST_SUITE_P(Transport, DirectS6, kBoth, integratorName);

TEST_P(DirectS6, PointLightFollowsCosineAndInverseSquare)
{
    Scene scene;
    addRectangle(scene, {vec3(-2, 0, 2), vec3(4, 0, 0), vec3(0, 0, -4)}, addMaterial(scene, vec3(0)), kPage,
                 {vec2(1), vec2(63)});
    scene.lights.push_back(
        makeLight(LightType::Point, vec3(0.5f, 1.5f, -0.25f), vec3(0, -1, 0), 100.0f, LightMode::Baked));
    Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, transport());
    const auto estimates = bench.irradiance();
    for (std::size_t i = 0; i < estimates.size(); ++i) {
        const vec3 toLight = bench.scene.lights[0].position() - bench.positionOf(bench.map.texels[i]);
        const float d2 = glm::dot(toLight, toLight);
        const float expected = 100.0f / d2 * (toLight.y / std::sqrt(d2));
        EXPECT_NEAR(estimates[i].irradiance.x, expected, 2e-3f * expected);
    }
}

/// The lightmap holds no direct light of a mixed light, but all of a baked one; subtractive holds both. What the
/// integrator does not bring of subtractive's main light, a directional one, is made of its mask.
TEST_P(DirectS6, MixedLightsAreInTheLightmapOnlyInSubtractive)
{
    for (const LightMode mode : {LightMode::Realtime, LightMode::Mixed, LightMode::Baked}) {
        for (const MixedLightingMode mixing :
             {MixedLightingMode::BakedIndirect, MixedLightingMode::Shadowmask, MixedLightingMode::Subtractive}) {
            Scene scene;
            addRectangle(scene, {}, addMaterial(scene, vec3(0.5f)), kPage, {vec2(1), vec2(9)});
            scene.lights.push_back(makeLight(LightType::Directional, vec3(0), vec3(0, -1, 0), 7.0f, mode));
            Bench bench(std::move(scene), mixing, kPage, transport());
            const bool direct =
                mode == LightMode::Baked || (mode == LightMode::Mixed && mixing == MixedLightingMode::Subtractive);
            std::vector<IrradianceEstimate> estimates = bench.irradiance();
            std::vector<vec3> irradiance = splitEstimates(estimates).irradiance;
            std::optional<MainLight> main = findMainLight(bench.scene);
            EXPECT_EQ(main.has_value(), mode == LightMode::Mixed && mixing == MixedLightingMode::Subtractive);
            if (main) {
                EXPECT_EQ(irradiance[20].x, 0.0f);
                const IntegrationSettings settings = transport();
                ASSERT_TRUE(bakeMainLight({*bench.integrator, bench.geometry, bench.map, settings}, *main, {}));
                main->addTo(irradiance);
            }
            EXPECT_NEAR(irradiance[20].x, direct ? 7.0f : 0.0f, 1e-4f);
        }
    }
}

/// Subtractive's main light in the lightmap is its mask times what it gives without shadows, strength included; below a
/// pane and a wall, and on the side that faces away.
TEST_P(DirectS6, SubtractiveMainLightIsWhatItsMaskLetsArrive)
{
    Scene scene;
    const int black = addMaterial(scene, vec3(0));
    addRectangle(scene, {vec3(-2, 0, 2), vec3(4, 0, 0), vec3(0, 0, -4)}, black, kPage, {vec2(1), vec2(41)});
    addRectangle(scene, {vec3(-2, -1, -2), vec3(4, 0, 0), vec3(0, 0, 4)}, black, kPage, {vec2(43, 1), vec2(51, 9)});
    const int pane = addMaterial(scene, vec3(0.5f), vec3(0), true);
    scene.materials[std::size_t(pane)].alphaMode = Material::AlphaMode::Blend;
    scene.materials[std::size_t(pane)].baseColor.w = 0.6f;
    addRectangle(scene, {vec3(-9, 1, 9), vec3(8, 0, 0), vec3(0, 0, -18)}, pane, kPage);
    const int wall = addMaterial(scene, vec3(0), vec3(0), true);
    addRectangle(scene, {vec3(1, 1, 9), vec3(8, 0, 0), vec3(0, 0, -18)}, wall, kPage);
    scene.lights.push_back(makeLight(LightType::Directional, vec3(0), vec3(0, -1, 0), 10.0f, LightMode::Mixed));
    scene.lights[0].shadowStrength = 0.5f;
    IntegrationSettings settings = transport();
    settings.bounces = 0;
    Bench bench(std::move(scene), MixedLightingMode::Subtractive, kPage, settings);
    const std::vector<IrradianceEstimate> estimates = bench.irradiance();
    std::optional<MainLight> main = findMainLight(bench.scene);
    ASSERT_TRUE(main);
    ASSERT_TRUE(bakeMainLight({*bench.integrator, bench.geometry, bench.map, settings}, *main, {}));
    int seen[4] = {};
    for (std::size_t i = 0; i < estimates.size(); ++i) {
        const vec3 place = bench.positionOf(bench.map.texels[i]);
        if (place.y < -0.5f) { // faces down
            EXPECT_EQ(main->at(i), vec3(0.0f));
            EXPECT_EQ(main->mask()[i], vec4(0, 1, 1, 1));
            ++seen[0];
        } else if (std::abs(place.x + 1.0f) > 0.1f && std::abs(place.x - 1.0f) > 0.1f) {
            const int kind = place.x < -1.0f ? 1 : place.x < 1.0f ? 2 : 3;
            const float arrives = kind == 1 ? 0.4f : kind == 2 ? 1.0f : 0.0f;
            EXPECT_NEAR(main->transmittance[i].x, arrives, 0.002f);
            EXPECT_NEAR(main->at(i).x, 10.0f * (0.5f + 0.5f * main->transmittance[i].x), 1e-4f);
            ++seen[kind];
        }
    }
    for (const int count : seen) EXPECT_GT(count, 30);
}

/// The bake's shadow colour: the median of the light in the main light's shadow, by channel; the darkest twentieth with
/// a mask; what there would be where nothing is shadowed.
TEST(ShadowColorS23, IsTheLightWhereTheMainLightIsShadowed)
{
    MainLight main;
    std::vector<vec3> light;
    for (int i = 0; i < 100; ++i) { // in the sun, which tells nothing
        main.transmittance.emplace_back(1.0f);
        main.unshadowed.emplace_back(5.0f);
        light.emplace_back(50.0f);
    }
    for (int i = 0; i < 100; ++i) { // faces away
        main.transmittance.emplace_back(0.0f);
        main.unshadowed.emplace_back(0.0f);
        light.emplace_back(70.0f);
    }
    for (int i = 0; i <= 100; ++i) { // shadowed: 1…2, 3…2, 4
        main.transmittance.emplace_back(0.0f);
        main.unshadowed.emplace_back(5.0f);
        light.emplace_back(1.0f + 0.01f * float(i), 3.0f - 0.01f * float(i), 4.0f);
    }
    for (int i = 0; i < 40; ++i) { // and covered by what stands there
        main.transmittance.emplace_back(0.0f);
        main.unshadowed.emplace_back(5.0f);
        light.emplace_back(0.001f);
    }
    std::vector<uint8_t> valid(light.size(), 1);
    const auto near = [](vec3 a, vec3 b) { return glm::length(a - b) < 0.02f; };
    EXPECT_TRUE(near(chooseShadowColor(main, light, valid, false), vec3(1.5f, 2.5f, 4.0f)));
    EXPECT_TRUE(near(chooseShadowColor(main, light, valid, true), vec3(1.05f, 2.05f, 4.0f)));
    std::fill(valid.begin() + 200, valid.end(), uint8_t(0));
    EXPECT_EQ(chooseShadowColor(main, light, valid, false), vec3(50.0f)) << "no shadow: the light beside the sun's";
    std::fill(valid.begin(), valid.end(), uint8_t(0));
    EXPECT_EQ(chooseShadowColor(main, light, valid, false), vec3(0.0f));
}

/// Objects and materials that receive no shadows: their baked direct light, and masks of 1.
TEST_P(DirectS6, SurfacesWithoutShadowsAreLitAsIfNothingStoodThereS30)
{
    for (const bool byMaterial : {false, true}) {
        Scene scene;
        const int plain = addMaterial(scene, vec3(0));
        const int unshadowed = addMaterial(scene, vec3(0));
        scene.materials[std::size_t(unshadowed)].receiveShadows = !byMaterial;
        addRectangle(scene, {vec3(-2, 0, 2), vec3(2, 0, 0), vec3(0, 0, -4)}, plain, kPage, {vec2(1), vec2(21, 41)});
        addRectangle(scene, {vec3(0, 0, 2), vec3(2, 0, 0), vec3(0, 0, -4)}, unshadowed, kPage,
                     {vec2(31, 1), vec2(51, 41)});
        scene.objects.back().receiveShadows = byMaterial;
        const int roof = addMaterial(scene, vec3(0), vec3(0), true);
        addRectangle(scene, {vec3(-9, 1, 9), vec3(18, 0, 0), vec3(0, 0, -18)}, roof, kPage); // over both
        scene.lights.push_back(makeLight(LightType::Directional, vec3(0), vec3(0, -1, 0), 10.0f, LightMode::Baked));
        scene.lights.push_back(makeLight(LightType::Directional, vec3(0), vec3(0, -1, 0), 3.0f, LightMode::Mixed));
        IntegrationSettings settings = transport();
        settings.bounces = 0;
        Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, settings);
        const std::vector<IrradianceEstimate> estimates = bench.irradiance();
        const std::vector<vec4> mask = bench.shadowmask();
        int seen[2] = {};
        for (std::size_t i = 0; i < estimates.size(); ++i) {
            const bool receives = bench.map.texels[i].x < 25;
            EXPECT_NEAR(estimates[i].irradiance.x, receives ? 0.0f : 10.0f, 1e-4f);
            EXPECT_EQ(mask[i].x, receives ? 0.0f : 1.0f);
            ++seen[receives ? 1 : 0];
        }
        EXPECT_GT(seen[0], 500);
        EXPECT_GT(seen[1], 500);
    }
}

/// Folds finer than texels: each texel is half a slope that faces the sun, behind a screen, and half one that the sun
/// grazes. Its light is the grazed half's, not half of what both have without the screen.
TEST_P(DirectS6, ShadowsOnTheBrighterSideOfFoldsCountAsMuch)
{
    constexpr int kFolds = 24;
    const vec3 facing(0, 0.8f, 0.6f);
    const vec3 grazed(0, 0.8f, -0.6f);
    Scene scene;
    const int black = addMaterial(scene, vec3(0), vec3(0), true);
    MeshPart part;
    part.material = black;
    const auto addSlope = [&](vec3 from, vec3 to, vec3 normal, float row) {
        const vec3 along(24, 0, 0);
        const auto first = uint32_t(part.positions.size());
        for (const vec3 corner : {from, to, to + along, from + along}) part.positions.push_back(corner);
        part.normals.insert(part.normals.end(), 4, normal);
        for (const vec2 texel : {vec2(2, row), vec2(2, row + 0.5f), vec2(26, row + 0.5f), vec2(26, row)})
            part.lightmapUv.push_back(texel / float(kPage));
        for (const uint32_t corner : {0u, 1u, 2u, 0u, 2u, 3u}) part.indices.push_back(first + corner);
    };
    for (int i = 0; i < kFolds; ++i) {
        const vec3 top(0, 0.375f, float(i));
        const vec3 foot(0, 0, float(i) + 0.5f);
        addSlope(top, foot, facing, 2.0f + float(i));
        addSlope(foot, top + vec3(0, 0, 1), grazed, 2.5f + float(i));
        addRectangle(scene, {top + 0.01f * facing, foot - top, vec3(24, 0, 0)}, black, kPage);
    }
    addObject(scene, std::move(part));
    scene.lights.push_back(makeLight(LightType::Directional, vec3(0), -facing, 1.0f, LightMode::Baked));
    Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, transport());
    const double expected = 0.5 * double(glm::dot(grazed, facing));
    const Statistics s = compare(bench.irradiance(), expected);
    EXPECT_NEAR(s.mean, expected, 0.04 * expected);
    EXPECT_LT(s.worst, 0.2);
}

/// Stripes finer than texels whose normals lean to all sides, a little: their light differs by a tenth, and a texel's
/// is their mean.
TEST_P(DirectS6, GentleFoldsHaveTheirMean)
{
    constexpr int kRows = 32;
    constexpr int kStripes = 5; // of a texel
    Scene scene;
    MeshPart part;
    part.material = addMaterial(scene, vec3(0));
    std::vector<float> expected;
    for (int row = 0; row < kRows; ++row) {
        float sum = 0.0f;
        for (int stripe = 0; stripe < kStripes; ++stripe) {
            const auto first = uint32_t(part.positions.size());
            const float lean = 0.5f * unitFloat(hashPcg(first));
            for (const vec2 corner : {vec2(0, 0), vec2(0, 1), vec2(1, 1), vec2(1, 0)}) {
                const vec2 at(float(kRows) * corner.x, float(row) + (float(stripe) + corner.y) / float(kStripes));
                part.positions.emplace_back(at.x, 0.0f, at.y);
                part.normals.emplace_back(std::sin(lean), std::cos(lean), 0.0f);
                part.lightmapUv.push_back((vec2(2) + at) / float(kPage));
            }
            for (const uint32_t corner : {0u, 1u, 2u, 0u, 2u, 3u}) part.indices.push_back(first + corner);
            sum += std::cos(lean) / float(kStripes);
        }
        expected.push_back(sum);
    }
    addObject(scene, std::move(part));
    scene.lights.push_back(makeLight(LightType::Directional, vec3(0), vec3(0, -1, 0), 1.0f, LightMode::Baked));
    IntegrationSettings settings = transport();
    settings.shadowSamples = 32;
    Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, settings);
    const std::vector<IrradianceEstimate> estimates = bench.irradiance();
    double squares = 0.0;
    for (std::size_t i = 0; i < estimates.size(); ++i) {
        const int row = int(bench.map.texels[i].y) - 2;
        ASSERT_TRUE(row >= 0 && row < kRows);
        const float error = estimates[i].irradiance.x / expected[std::size_t(row)] - 1.0f;
        squares += double(error * error) / double(estimates.size());
    }
    EXPECT_LT(std::sqrt(squares), 0.0025);
}

} // namespace
} // namespace halflight::test::direct_light_test
