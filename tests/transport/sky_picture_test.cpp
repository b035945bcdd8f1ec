// Light of a sky's picture: against closed forms, sums over the picture, and the same light found in other ways (S6).

#include "bake/both_integrators.h"
#include "bake/seeds.h"
#include "bake/test_sky.h"
#include "transport/sample/sky_light.h"

#include "halflight/render/probes.h"
#include "halflight/shading/random.h"
#include "halflight/shading/sampling.h"
#include "halflight/shading/sh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace halflight::test::sky_picture_test {
namespace {

constexpr int kPage = 64;

class SkyPictureS6 : public BothIntegrators {};
INSTANTIATE_TEST_SUITE_P(Transport, SkyPictureS6, kBoth, integratorName);

/// Integral over the sphere, by a grid of sub-texels of the sky's picture.
double overSphere(const Sky& sky, int perTexel, const std::function<double(vec3)>& value)
{
    const ivec2 size = sky.picture->size() * perTexel;
    const vec2 turn(std::cos(sky.rotationRadians), std::sin(sky.rotationRadians));
    double sum = 0.0;
    for (int y = 0; y < size.y; ++y) {
        const double band = std::cos(double(y) / size.y * double(kPi)) - std::cos(double(y + 1) / size.y * double(kPi));
        for (int x = 0; x < size.x; ++x) {
            const vec3 d = shading::skyPictureDirection((vec2(x, y) + 0.5f) / vec2(size), turn);
            sum += value(d) * band * 2.0 * double(kPi) / size.x;
        }
    }
    return sum;
}

Rectangle squareTowards(vec3 normal)
{
    vec3 u;
    vec3 v;
    shading::orthonormalBasis(normal, u, v);
    return {-u - v, 2.0f * u, 2.0f * v};
}

Scene squareUnder(Sky sky, vec3 normal)
{
    Scene scene;
    addRectangle(scene, squareTowards(normal), addMaterial(scene, vec3(0.0f)), kPage, {vec2(1), vec2(33)});
    scene.sky = std::move(sky);
    return scene;
}

// A picture of one value is the even sky: pi times its radiance.
TEST_P(SkyPictureS6, ConstantPictureIsTheConstantSky)
{
    const Sky sky = skyOf(ImageRgb32f(8, 4, vec3(1.5f)));
    Bench bench(squareUnder(sky, vec3(0, 1, 0)), MixedLightingMode::Shadowmask, kPage, transport());
    EXPECT_LT(compare(bench.irradiance(), 1.5 * double(kPi)).worst, 1e-5);
}

// Under a + b y a surface with normal n receives pi a + 2 pi / 3 b n.y.
TEST_P(SkyPictureS6, LinearPictureHasItsClosedForm)
{
    IntegrationSettings settings = transport();
    settings.samples = 64;
    for (const vec3 normal : {vec3(0, 1, 0), vec3(0, -1, 0), vec3(1, 0, 0), glm::normalize(vec3(1, 1, -1))}) {
        const Sky sky = skyOf(skyPicture(128, [](vec3 d) { return vec3(2.0f + 1.5f * d.y); }), 0.7f);
        Bench bench(squareUnder(sky, normal), MixedLightingMode::Shadowmask, kPage, settings);
        const double expected = double(kPi) * (2.0 + 2.0 / 3.0 * 1.5 * double(normal.y));
        EXPECT_NEAR(compare(bench.irradiance(), expected).mean, expected, 2e-3 * expected) << normal.y;
    }
}

// A sun of 1e5 times the sky, half a degree wide, above a plate that covers x < 0 at a height of 1 m: light, shadow and
// penumbra are the sums over the picture of what a texel sees. Rays without importance sampling would meet the sun once
// in 50000.
TEST_P(SkyPictureS6, SmallSunHasSharpShadowsWithoutNoise)
{
    const Sky sky = skyOf(sunPicture(1024, vec3(1, 2, 0.5f), 0.008f, 1.0e5f));
    Scene scene;
    const int black = addMaterial(scene, vec3(0.0f), vec3(0.0f), true);
    addRectangle(scene, {vec3(-1, 0, 0.25f), vec3(2, 0, 0), vec3(0, 0, -0.5f)}, black, kPage, {vec2(1), vec2(33, 9)});
    addRectangle(scene, {vec3(-50, 1, 50), vec3(50, 0, 0), vec3(0, 0, -100)}, black, kPage);
    scene.sky = sky;
    IntegrationSettings settings = transport();
    settings.samples = 64;
    Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, settings);
    const std::vector<IrradianceEstimate> found = bench.irradiance();
    const SkyLight light(sky);
    const auto expectedAt = [&](float x) {
        return overSphere(sky, 2, [&](vec3 d) {
            if (d.y <= 0.0f) return 0.0;
            double seen = 0.0; // mean over the texel's width; the plate is where -50 < x + d.x / d.y < 0
            for (int i = 0; i < 8; ++i) {
                const float at = x + ((float(i) + 0.5f) / 8.0f - 0.5f) * 0.0625f + d.x / d.y;
                seen += at < -50.0f || at > 0.0f || std::abs(d.z / d.y) > 50.0f ? 0.125 : 0.0;
            }
            return seen > 0.0 ? seen * double(d.y * light.radiance(d).y) : 0.0;
        });
    };
    std::vector<double> expected(32);
    for (int i = 0; i < 32; ++i) expected[std::size_t(i)] = expectedAt(-1.0f + (float(i) + 0.5f) * 0.0625f);
    EXPECT_GT(expected[31], 10.0 * expected[0]); // the sun is there, and its shadow
    double sum = 0.0;
    double total = 0.0;
    double squares = 0.0;
    int texels = 0;
    for (std::size_t t = 0; t < found.size(); ++t) {
        const Texel& texel = bench.map.texels[t];
        if (texel.x < 1 || texel.x >= 33 || texel.y < 1 || texel.y >= 9) continue;
        const double e = expected[std::size_t(texel.x - 1)];
        sum += double(found[t].irradiance.y);
        total += e;
        squares += (double(found[t].irradiance.y) - e) * (double(found[t].irradiance.y) - e);
        ++texels;
    }
    EXPECT_NEAR(sum, total, 0.005 * total);
    EXPECT_LT(std::sqrt(squares / texels), 0.05 * expected[31]);
}

// Sunlight that a window lets in is reflected on: the radiance cache has the light of path tracing.
TEST(SkyPictureBouncesS6, BothIntegratorsAgree)
{
    SeedMean mean[2];
    for (const IntegratorKind kind : {IntegratorKind::Cache, IntegratorKind::Path}) {
        Scene scene;
        const int walls = addMaterial(scene, vec3(0.7f));
        addBox(scene, vec3(-1), vec3(1), walls, true, kPage);
        scene.meshes.erase(scene.meshes.begin() + 3); // towards +X
        scene.objects.pop_back();
        scene.sky = skyOf(sunPicture(512, vec3(1, 0.7f, 0.2f), 0.02f, 3.0e4f));
        IntegrationSettings settings;
        settings.integrator = kind;
        settings.samples = kind == IntegratorKind::Cache ? 32 : 128;
        mean[int(kind == IntegratorKind::Path)] = meanIrradiance(bakedBySeeds({scene, settings}));
    }
    expectSameMean(mean[0], mean[1], {.resolved = 0.01});
    EXPECT_GT(mean[1].mean, 10.0);
}

// A probe in the open has the picture's own coefficients.
TEST(SkyPictureProbesS6, ProbesHoldThePicture)
{
    Sky sky = skyOf(sunPicture(512, vec3(-0.5f, 1, 2), 0.01f, 1.0e5f), 0.4f);
    Scene scene;
    addRectangle(scene, {vec3(0, -1000, 0)}, addMaterial(scene, vec3(0.0f)), kPage);
    scene.sky = sky;
    Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, {});
    const vec3 position(0.0f);
    const uint32_t which = 0;
    std::vector<ProbeEstimate> out(1);
    ASSERT_TRUE(bench.integrator->probes({&position, 1}, {&which, 1}, 4096, out, {}));
    const ProbeSample expected = skyProbe(sky);
    const SkyLight light(sky);
    for (std::size_t i = 0; i < 9; ++i) {
        const double exact =
            overSphere(sky, 2, [&](vec3 d) { return double(light.radiance(d).y * shading::shBasis(int(i), d)); });
        EXPECT_NEAR(out[0].radiance[i].y, exact, 0.02 * double(expected.radiance[0].y)) << i;
        EXPECT_NEAR(expected.radiance[i].y, exact, 0.003 * double(expected.radiance[0].y)) << i;
    }
}

TEST(SkyLight, SamplesFollowTheirDensityAndSumToTheBrightPart)
{
    const Sky sky = skyOf(
        skyPicture(64, [](vec3 d) { return vec3(d.x > 0.95f ? 900.0f : 1.0f, d.y > 0.98f ? 2000.0f : 0.5f, 0.3f); }),
        -1.1f);
    const SkyLight light(sky);
    ASSERT_TRUE(light.samples());
    glm::dvec3 sum(0.0);
    const int count = 200000;
    for (int i = 0; i < count; ++i) {
        const vec2 u(unitFloat(hashCombine(1u, uint32_t(i))), unitFloat(hashCombine(2u, uint32_t(i))));
        const SkyLight::Sample s = light.sample(u);
        ASSERT_NEAR(glm::length(s.direction), 1.0f, 1e-5f);
        sum += glm::dvec3(s.radiance / s.pdf) / double(count);
        if (i >= 1000) continue;
        EXPECT_NEAR(light.pdf(s.direction), s.pdf, 0.02f * s.pdf + 1e-3f);
        EXPECT_LT(glm::distance(light.brightRadiance(s.direction), s.radiance), 0.02f * (1.0f + s.radiance.y));
    }
    EXPECT_NEAR(overSphere(sky, 8, [&](vec3 d) { return double(light.pdf(d)); }), 1.0, 0.002);
    const double expected = overSphere(sky, 8, [&](vec3 d) { return double(light.brightRadiance(d).y); });
    EXPECT_NEAR(double(light.brightIlluminance()),
                overSphere(sky, 8, [&](vec3 d) { return double(luminance(light.brightRadiance(d))); }),
                0.05 * expected);
    EXPECT_NEAR(sum.y, expected, 0.01 * expected);
}

// A gradient and a gentle picture have no bright part: no shadow rays for them.
TEST(SkyLight, GentlePicturesNeedNoSampling)
{
    EXPECT_FALSE(SkyLight(Sky{vec3(9), vec3(1), vec3(0)}).samples());
    EXPECT_FALSE(SkyLight(skyOf(skyPicture(32, [](vec3 d) { return vec3(1.0f + d.y); }))).samples());
    EXPECT_FALSE(SkyLight(skyOf(ImageRgb32f(4, 2))).samples());
    EXPECT_TRUE(SkyLight(skyOf(ImageRgb32f(4, 2))).black());
}

} // namespace
} // namespace halflight::test::sky_picture_test
