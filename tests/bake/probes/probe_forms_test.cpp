// Probes and mean directions against closed forms (spec S10, S14, S32).

#include "bake/cache/cached_integrator.h"
#include "bake/pages/encode.h"
#include "bake/probes/probes.h"
#include "bake/test_scene.h"

#include "halflight/shading/sh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace halflight::test::probe_forms_test {
namespace {

constexpr int kPage = 64;

vec3 irradianceFromSh(const SphericalHarmonicsL2& sh, vec3 n)
{
    vec3 sum(0.0f);
    for (int i = 0; i < 9; ++i) sum += sh[std::size_t(i)] * shading::shIrradianceWeight(i, n);
    return sum;
}

ProbeEstimate probeAt(Scene scene, vec3 position, int samples, MixedLightingMode mode = MixedLightingMode::Shadowmask)
{
    IntegrationSettings settings;
    settings.probeSamples = samples;
    settings.shadowSamples = 1024;
    Bench bench(std::move(scene), mode, kPage, settings);
    std::vector<ProbeEstimate> out(1);
    EXPECT_TRUE(bench.integrator->probes(std::vector<vec3>{position}, std::vector<uint32_t>{0}, 0, out, {}));
    return out[0];
}

/// Sky radiance 1: the constant coefficient is sqrt(4 pi), all others 0. Sky radiance 1 + y: the y coefficient is
/// sqrt(4 pi / 3) as well, and irradiance upward is pi + 2 pi / 3.
/// An even sky's mean direction is 2/3 of the normal; a distant light's is its own; a mixture's is between them, by
/// irradiance.
TEST(DirectionalS32, MomentsOfSkyAndSun)
{
    const vec3 toSun = glm::normalize(vec3(2, 1, 1));
    for (const auto& [lux, nits] : {std::pair(0.0f, 2.0f), {5.0f, 0.0f}, {5.0f, 2.0f}}) {
        for (const IntegratorKind kind : {IntegratorKind::Cache, IntegratorKind::Path}) {
            Scene scene;
            addRectangle(scene, {}, addMaterial(scene, vec3(0.5f)), kPage, {vec2(1), vec2(9)});
            scene.sky = {vec3(nits), vec3(nits), vec3(nits)};
            if (lux > 0.0f)
                scene.lights.push_back(makeLight(LightType::Directional, vec3(0), -toSun, lux, LightMode::Baked));
            IntegrationSettings settings;
            settings.samples = 1024;
            settings.integrator = kind;
            Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, settings);
            const vec3 expected = kPi * nits * (2.0f / 3.0f) * vec3(0, 1, 0) + lux * toSun.y * toSun;
            const auto estimates = bench.irradiance();
            const float irradiance = kPi * nits + lux * toSun.y;
            EXPECT_LT(glm::distance(estimates[20].moment, expected), 0.01f * irradiance) << lux << ' ' << nits;
            // The page's colour, decoded, is their quotient.
            const ImageRgb32f light(1, 1, estimates[20].irradiance);
            const ImageRgb32f moment(1, 1, estimates[20].moment);
            const u8vec4 texel = encodeDirections({light}, {moment})[0](0, 0);
            EXPECT_LT(glm::distance(vec3(texel) / 127.5f - 1.0f, expected / irradiance), 0.02f);
        }
    }
}

/// An emissive panel that the gather samples directly counts from where it hangs.
TEST(DirectionalS32, MomentOfAPanelPointsAtIt)
{
    for (const IntegratorKind kind : {IntegratorKind::Cache, IntegratorKind::Path}) {
        Scene scene;
        addRectangle(scene, {vec3(0), vec3(0.1f, 0, 0), vec3(0, 0, -0.1f)}, addMaterial(scene, vec3(0)), kPage,
                     {vec2(1), vec2(4)});
        const vec3 center(3, 2, 0);
        const vec3 facing = glm::normalize(-center);
        const vec3 across = glm::normalize(glm::cross(facing, vec3(0, 0, 1)));
        addRectangle(scene, {center - 0.05f * (across + vec3(0, 0, 1)), 0.1f * across, vec3(0, 0, 0.1f)},
                     addMaterial(scene, vec3(0), vec3(1000), true), kPage);
        IntegrationSettings settings;
        settings.samples = 256;
        settings.integrator = kind;
        Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, settings);
        for (const IrradianceEstimate& e : bench.irradiance()) {
            ASSERT_GT(e.irradiance.x, 0.0f);
            EXPECT_LT(glm::distance(e.moment / luminance(e.irradiance), glm::normalize(center)), 0.05f);
        }
    }
}

TEST(ProbeS14, ConstantAndCosineSky)
{
    Scene constant;
    constant.sky = {vec3(1), vec3(1), vec3(1)};
    const ProbeEstimate a = probeAt(constant, vec3(0), 4096);
    EXPECT_NEAR(a.radiance[0].x, std::sqrt(4.0f * kPi), 0.01f);
    for (std::size_t i = 1; i < 9; ++i) EXPECT_NEAR(a.radiance[i].x, 0.0f, 0.02f) << i;
    EXPECT_NEAR(irradianceFromSh(a.radiance, vec3(0, 1, 0)).x, kPi, 0.02f);

    Scene cosine;
    cosine.sky = {vec3(2), vec3(1), vec3(0)};
    const ProbeEstimate b = probeAt(cosine, vec3(0), 4096);
    EXPECT_NEAR(b.radiance[0].x, std::sqrt(4.0f * kPi), 0.01f);
    EXPECT_NEAR(b.radiance[1].x, std::sqrt(4.0f * kPi / 3.0f), 0.01f);
    for (std::size_t i = 2; i < 9; ++i) EXPECT_NEAR(b.radiance[i].x, 0.0f, 0.02f) << i;
    EXPECT_NEAR(irradianceFromSh(b.radiance, vec3(0, 1, 0)).x, kPi + 2.0f * kPi / 3.0f, 0.03f);
    EXPECT_NEAR(irradianceFromSh(b.radiance, vec3(0, -1, 0)).x, kPi - 2.0f * kPi / 3.0f, 0.03f);
}

/// A fully baked light in the probe: a delta in direction. Towards it, an L2 irradiance is 17/16 of the light's
/// (1/4 + 1/2 + 5/16 from the bands).
TEST(ProbeS10, FullyBakedLightIsInTheProbes)
{
    Scene scene;
    scene.lights.push_back(makeLight(LightType::Point, vec3(0, 2, 0), vec3(0, -1, 0), 8.0f, LightMode::Baked));
    EXPECT_NEAR(irradianceFromSh(probeAt(scene, vec3(0), 64).radiance, vec3(0, 1, 0)).x, 2.0f * 17.0f / 16.0f, 1e-3f);
    scene.lights[0].mode = LightMode::Mixed;
    EXPECT_EQ(irradianceFromSh(probeAt(scene, vec3(0), 64).radiance, vec3(0, 1, 0)).x, 0.0f);
}

/// A disc of radius r at distance a hides part of a light of radius R at distance d: what is left is
/// 1 - (r d / (a R))^2. Here the disc is a fine fan.
TEST(ProbeS14, OcclusionUnderADisc)
{
    for (const float discRadius : {0.0f, 0.05f, 0.1f, 0.2f}) {
        Scene scene;
        const int black = addMaterial(scene, vec3(0), vec3(0), true);
        if (discRadius > 0.0f) {
            MeshPart part;
            part.positions = {vec3(0, 1, 0)};
            constexpr int kSides = 256;
            for (int i = 0; i < kSides; ++i) {
                const float angle = 2.0f * kPi * float(i) / kSides;
                part.positions.push_back(vec3(discRadius * std::cos(angle), 1, discRadius * std::sin(angle)));
                part.indices.insert(part.indices.end(), {0u, uint32_t(1 + (i + 1) % kSides), uint32_t(1 + i)});
            }
            part.normals.assign(part.positions.size(), vec3(0, 1, 0));
            part.material = black;
            addObject(scene, std::move(part));
        }
        scene.lights.push_back(makeLight(LightType::Point, vec3(0, 4, 0), vec3(0, -1, 0), 8.0f, LightMode::Mixed));
        scene.lights[0].radiusMeters = 0.6f;
        const float ratio = discRadius * 4.0f / 0.6f;
        const ProbeEstimate e = probeAt(scene, vec3(0), 16);
        EXPECT_NEAR(e.occlusion[0], std::max(0.0f, 1.0f - ratio * ratio), 0.02f) << discRadius;
        EXPECT_EQ(e.occlusion[1], 1.0f);
        EXPECT_EQ(e.occlusion[2], 1.0f);
        EXPECT_EQ(e.occlusion[3], 1.0f);
    }
}

/// A probe inside a solid sees its back faces and is marked; outside it is not.
TEST(ProbeS14, InsideASolidIsInvalid)
{
    Scene scene;
    addBox(scene, vec3(-1), vec3(1), addMaterial(scene, vec3(0.5f)), false);
    EXPECT_FALSE(probeAt(scene, vec3(0.3f), 64).valid);
    EXPECT_TRUE(probeAt(scene, vec3(0, 1.5f, 0), 64).valid);
}

/// A probe in the plane of a black sheet has the light of one of its sides: half of an even sky. Its rays do not end on
/// the sheet at once.
TEST(ProbeS14, InThePlaneOfASheetHasTheLightOfASide)
{
    for (const int normal : {0, 1, 2}) {
        Scene scene;
        scene.sky = {vec3(1), vec3(1), vec3(1)};
        vec3 u(0.0f);
        vec3 v(0.0f);
        u[(normal + 1) % 3] = v[(normal + 2) % 3] = 200.0f;
        addRectangle(scene, {-0.5f * (u + v), u, v}, addMaterial(scene, vec3(0), vec3(0), true), kPage);
        const ProbeEstimate e = probeAt(scene, 0.001f * u + 0.002f * v, 4096);
        EXPECT_NEAR(e.radiance[0].x, 0.5f * std::sqrt(4.0f * kPi), 0.05f) << normal;
        EXPECT_NEAR(std::abs(e.radiance[std::array<std::size_t, 3>{3, 1, 2}[std::size_t(normal)]].x),
                    0.25f * std::sqrt(12.0f * kPi), 0.05f)
            << normal;
    }
}

/// `--probe-layout grid`: as many probes as the grid has places, each where the format says, and those inside the box
/// marked, but not black. The light around the box is that of an even sky and a black box below: the mean of neighbours
/// lies between theirs.
TEST(ProbeS14, AGridStaysAGridAndItsInvalidProbesAreFilled)
{
    IntegrationSettings settings;
    settings.probeSamples = 64;
    Scene scene;
    scene.sky = {vec3(1.0f), vec3(1.0f), vec3(1.0f)};
    addBox(scene, vec3(-1), vec3(1), addMaterial(scene, vec3(0.0f)), false);
    addBox(scene, vec3(-3, -3.2f, -3), vec3(3, -3, 3), addMaterial(scene, vec3(0.0f)), false);
    addBox(scene, vec3(2.9f, 2.9f, 2.9f), vec3(3), addMaterial(scene, vec3(0.0f)), false); // widens the bounds
    Bench bench(std::move(scene), MixedLightingMode::Shadowmask, 64, settings);
    const CachedIntegrator cached{*bench.integrator, bench.geometry, bench.map, settings};
    std::vector<std::string> warnings;
    const ProbeSet set = bakeProbes(bench.scene, 0.75f, ProbeLayout::Grid, false, cached, warnings, {})->set;
    ASSERT_EQ(set.probes.size(), std::size_t(set.size.x * set.size.y * set.size.z));
    int invalid = 0;
    for (int i = 0; i < int(set.probes.size()); ++i) {
        const Probe& probe = set.probes[std::size_t(i)];
        const ivec3 at(i % set.size.x, i / set.size.x % set.size.y, i / (set.size.x * set.size.y));
        EXPECT_NEAR(glm::distance(probe.position, set.origin + set.spacingMeters * vec3(at)), 0.0f, 1.0e-5f);
        const vec3 away = glm::abs(probe.position);
        if (std::max({away.x, away.y, away.z}) < 1.0f) EXPECT_FALSE(probe.valid) << i;
        invalid += probe.valid ? 0 : 1;
        EXPECT_GT(probe.radiance[0].x, 0.2f) << i; // an even sky all around is 2 sqrt(pi) = 3.54
        EXPECT_LE(probe.radiance[0].x, 3.55f) << i;
    }
    EXPECT_GE(invalid, 8);
}

/// Means of neighbours spread from the valid probes inwards, and change no valid one.
TEST(ProbeS14, InvalidProbesOfAGridGetTheMeanOfTheirNeighbours)
{
    ProbeSet grid;
    grid.size = ivec3(5, 1, 1);
    for (int i = 0; i < 5; ++i) {
        Probe probe;
        probe.position = vec3(i, 0, 0);
        probe.valid = i == 0 || i == 4;
        probe.radiance.fill(vec3(i == 4 ? 8.0f : 2.0f));
        probe.occlusion.layers[0] = vec4(i == 4 ? 1.0f : 0.0f);
        grid.probes.push_back(probe);
    }
    fillInvalidProbes(grid);
    const float right[] = {2.0f, 2.0f, 5.0f, 8.0f, 8.0f};
    for (std::size_t i = 0; i < 5; ++i) {
        EXPECT_EQ(grid.probes[i].radiance[3].y, right[i]) << i;
        EXPECT_EQ(grid.probes[i].valid, i == 0 || i == 4);
    }
    EXPECT_EQ(grid.probes[2].occlusion[2], 0.5f);
}

} // namespace
} // namespace halflight::test::probe_forms_test
