// Light and darkness stay on their side of closed surfaces (spec S6).

#include "bake/both_integrators.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

namespace halflight::test::leaks_test {
namespace {

constexpr int kPage = 64;

class LeaksS6 : public BothIntegrators {};
INSTANTIATE_TEST_SUITE_P(Transport, LeaksS6, kBoth, integratorName);

/// Floor texels under a box that stands on it are inside geometry; those beside it are not, and see the sky.
TEST_P(LeaksS6, TexelsUnderABoxAreMarked)
{
    Scene scene;
    scene.sky = {vec3(1), vec3(1), vec3(1)};
    const int grey = addMaterial(scene, vec3(0.5f));
    addRectangle(scene, {vec3(-2, 0, 2), vec3(4, 0, 0), vec3(0, 0, -4)}, grey, kPage, {vec2(0), vec2(64)});
    addBox(scene, vec3(-0.53f, -0.5f, -0.53f), vec3(0.53f, 1, 0.53f), grey, false);
    Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, transport());
    const auto estimates = bench.irradiance();
    const float texel = 4.0f / 64.0f;
    for (std::size_t i = 0; i < estimates.size(); ++i) {
        const vec3 p = glm::abs(bench.positionOf(bench.map.texels[i]));
        const float distance = std::max(p.x, p.z);
        if (distance < 0.53f - texel) EXPECT_FALSE(estimates[i].valid);
        if (distance > 0.53f + 0.5f * texel) {
            EXPECT_TRUE(estimates[i].valid);
            EXPECT_GT(estimates[i].irradiance.x, 0.4f * kPi) << "a dark rim at " << distance;
        }
    }
}

/// Solids inside solids: a texel within two of them at once is inside, though its rays may meet a front face first.
TEST_P(LeaksS6, TexelsInsideNestedSolidsAreMarked)
{
    Scene scene;
    scene.sky = {vec3(1), vec3(1), vec3(1)};
    const int grey = addMaterial(scene, vec3(0.5f));
    addRectangle(scene, {vec3(-0.2f, 0, 0.2f), vec3(0.4f, 0, 0), vec3(0, 0, -0.4f)}, grey, kPage, {vec2(0), vec2(64)});
    // One mesh for each box, so that each is closed.
    for (const float half : {1.0f, 0.1f}) {
        const std::size_t first = scene.meshes.size();
        const vec3 center(0, half == 1.0f ? 0.0f : 0.15f, 0);
        addBox(scene, center - half, center + half, grey, false);
        joinObjects(scene, first);
    }
    Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, transport());
    for (const IrradianceEstimate& e : bench.irradiance()) EXPECT_FALSE(e.valid);
}

/// A hood without a bottom stands on a floor with low boards, one in each block of texels: not all points of a block
/// are mutually visible, and those of each texel are behind the hood.
TEST_P(LeaksS6, TexelsBetweenBoardsUnderAHoodAreMarked)
{
    Scene scene;
    scene.sky = {vec3(1), vec3(1), vec3(1)};
    const int grey = addMaterial(scene, vec3(0.5f));
    constexpr float kTexel = 2.0f / float(kPage);
    addRectangle(scene, {vec3(-1, 0, 1), vec3(2, 0, 0), vec3(0, 0, -2)}, grey, kPage, {vec2(0), vec2(kPage)});
    for (int block = 0; block < kPage / 4; ++block) {
        const vec3 corner(-1.0f + (4.0f * float(block) + 2.0f) * kTexel, 0, 1);
        addRectangle(scene, {corner, vec3(0, 0, -2), vec3(0, 0.2f * kTexel, 0)}, grey, kPage);
    }
    const vec3 corner(-2, -0.1f, -2);
    const vec3 x(4, 0, 0);
    const vec3 y(0, 3, 0);
    const vec3 z(0, 0, 4);
    for (const Rectangle& face : {Rectangle{corner, y, x}, Rectangle{corner + z, x, y}, Rectangle{corner, z, y},
                                  Rectangle{corner + x, y, z}, Rectangle{corner + y, z, x}})
        addRectangle(scene, face, grey, kPage);
    Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, transport());
    for (const IrradianceEstimate& e : bench.irradiance()) EXPECT_FALSE(e.valid);
}

/// A room with thick walls, modelled as one hollow body: its inside is outside the solid and takes light, its walls'
/// cores do not, and what a block in it covers is still inside the block.
TEST(LeaksS6, RoomsInHollowBodiesAreLit)
{
    Scene scene;
    const int grey = addMaterial(scene, vec3(0.5f));
    addBox(scene, vec3(-2.2f, -0.2f, -2.2f), vec3(2.2f, 2.7f, 2.2f), grey, false);
    addBox(scene, vec3(-2, 0, -2), vec3(2, 2.5f, 2), grey, true);
    joinObjects(scene, 0);
    const std::size_t block = scene.meshes.size();
    addBox(scene, vec3(-0.5f, -0.1f, -0.5f), vec3(0.5f, 1, 0.5f), grey, false);
    joinObjects(scene, block);
    // Two sheets to look with: on the floor, half of it under the block, and in the wall's core.
    addRectangle(scene, {vec3(-0.5f, 0.01f, 0.4f), vec3(2, 0, 0), vec3(0, 0, -0.8f)}, grey, kPage,
                 {vec2(1), vec2(31, 15)});
    addRectangle(scene, {vec3(2.1f, 0.5f, 0.5f), vec3(0, 1, 0), vec3(0, 0, -1)}, grey, kPage,
                 {vec2(33, 1), vec2(63, 15)});
    scene.lights.push_back(makeLight(LightType::Point, vec3(1.2f, 2.0f, 0), vec3(0, -1, 0), 10.0f, LightMode::Baked));
    Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, {});
    const auto estimates = bench.irradiance();
    int lit = 0;
    int hidden = 0;
    for (std::size_t i = 0; i < estimates.size(); ++i) {
        const vec3 p = bench.positionOf(bench.map.texels[i]);
        if (p.x > 0.6f && p.x < 1.9f) {
            EXPECT_TRUE(estimates[i].valid && estimates[i].irradiance.x > 0.5f) << p.x << ' ' << p.y << ' ' << p.z;
            ++lit;
        } else if (p.x < 0.4f || p.x > 2.05f) {
            EXPECT_FALSE(estimates[i].valid) << p.x << ' ' << p.y << ' ' << p.z;
            ++hidden;
        }
    }
    EXPECT_GT(lit, 50);
    EXPECT_GT(hidden, 100);
}

/// A closed room of single-sided walls in a bright sky stays black, but for rays through the edges of triangles.
TEST_P(LeaksS6, ClosedRoomInABrightSkyStaysDark)
{
    Scene scene;
    scene.sky = {vec3(1000), vec3(1000), vec3(1000)};
    addBox(scene, vec3(-3.1f, 0, -2.7f), vec3(3.3f, 2.9f, 4.1f), addMaterial(scene, vec3(0.8f)), true, kPage);
    Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, transport());
    double sum = 0.0;
    for (const IrradianceEstimate& e : bench.irradiance()) sum += e.irradiance.x;
    EXPECT_LT(sum / double(bench.map.texels.size()), 0.001 * 1000.0 * kPi);
}

} // namespace
} // namespace halflight::test::leaks_test
