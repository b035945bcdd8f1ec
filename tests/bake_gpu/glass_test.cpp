// Coloured glass on a device gives light the colours that it has on the processor, and those of closed forms (spec
// S35).

#include "bake/seeds.h"
#include "bake/test_room.h"
#include "bake/test_sky.h"
#include "bake_gpu/glass_court.h"
#include "bake_gpu/kernel_pair.h"
#include "bake_gpu/same_light.h"
#include "transport/colored_bench.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <iostream>

namespace halflight::test::device_glass_test {
namespace {

using DeviceGlassS35 = BakeDeviceTest;

bool isGray(vec3 color)
{
    return color.x == color.y && color.x == color.z;
}
bool isNear(vec3 a, vec3 b)
{
    return glm::distance(a, b) <= 1.0e-3f * (1.0f + glm::length(a));
}

/// From within the court up through its glass.
std::vector<Ray> courtRays(float length)
{
    std::vector<Ray> rays;
    for (uint32_t i = 0; i < kRays; ++i) {
        const auto number = [&](uint32_t k) { return 2.0f * unitFloat(hashCombine(i, k)) - 1.0f; };
        const vec3 from(1.9f * number(1), 1.0f + 0.9f * number(2), 1.9f * number(3));
        const vec3 to(1.9f * number(4), 3.2f, 1.9f * number(5));
        rays.push_back({from, 0.0f, glm::normalize(to - from), length});
    }
    rays[7].tMax = -1.0f;
    return rays;
}

struct Case {
    const char* name;
    Scene scene;
    std::vector<Ray> rays;
    bool shared = false; ///< its glass is an instance
};
std::vector<Case> cases()
{
    const Scene balls = balls::ballsOnFloor();
    return {{"court", glassCourt(), courtRays(kInfinity)},
            {"short rays in the court", glassCourt(), courtRays(1.0f)},
            {"solids", withGlassSkin(balls, false), randomRays(kInfinity), true},
            {"solids, not shared", balls::unshared(withGlassSkin(balls, false)), randomRays(2.0f)},
            {"shells", withGlassSkin(balls, true), randomRays(3.0f), true},
            {"shells, not shared", balls::unshared(withGlassSkin(balls, true)), randomRays(3.0f)}};
}

TEST_F(DeviceGlassS35, TransmittanceIsTheProcessors)
{
    for (const Case& of : cases()) {
        const Pair pair(of.scene, device);
        std::vector<vec3> a(kRays);
        std::vector<vec3> b(kRays);
        ASSERT_TRUE(pair.cpu.kernels().transmittance(of.rays, a));
        ASSERT_TRUE(pair.gpu.kernels().transmittance(of.rays, b));
        std::size_t colored = 0;
        std::size_t other = 0;
        for (std::size_t i = 0; i < kRays; ++i) {
            colored += isGray(a[i]) ? 0 : 1;
            other += isNear(a[i], b[i]) ? 0 : 1;
        }
        EXPECT_GT(colored, kRays / 20) << of.name;
        EXPECT_LT(other, kRays / 500) << of.name;
        EXPECT_EQ(b[7], vec3(1.0f));
    }
}

/// Both pass the same faces by chance, and take the same colour of them. In instances Embree's chance is of the ray in
/// the mesh's space: there the mean counts.
TEST_F(DeviceGlassS35, HitsHaveTheProcessorsTint)
{
    for (const Case& of : cases()) {
        const Pair pair(of.scene, device);
        std::vector<RayHit> a(kRays);
        std::vector<RayHit> b(kRays);
        ASSERT_TRUE(pair.cpu.kernels().nearest(of.rays, a, RayUse::Light));
        ASSERT_TRUE(pair.gpu.kernels().nearest(of.rays, b, RayUse::Light));
        std::size_t colored = 0;
        std::size_t other = 0;
        vec3 difference(0.0f); // of the light of a white sky
        vec3 squares(0.0f);
        for (std::size_t i = 0; i < kRays; ++i) {
            colored += isGray(a[i].tint) ? 0 : 1;
            other += a[i].found() == b[i].found() && isNear(a[i].tint, b[i].tint) ? 0 : 1;
            const vec3 d = (b[i].found() ? 0.0f : 1.0f) * b[i].tint - (a[i].found() ? 0.0f : 1.0f) * a[i].tint;
            difference += d;
            squares += d * d;
        }
        EXPECT_GT(colored, kRays / 20) << of.name;
        if (!of.shared) EXPECT_LT(other, kRays / 500) << of.name;
        for (int c = 0; c < 3; ++c) EXPECT_LT(std::abs(difference[c]), 4.0f * std::sqrt(squares[c]) + 1.0f) << of.name;
        EXPECT_EQ(b[7].tint, vec3(1.0f));
    }
}

/// Those of glass, and those with holes, count where a ray does not pass.
TEST_F(DeviceGlassS35, SolidsCrossedAreTheProcessors)
{
    expectSameCrossings(balls::unshared(withGlassSkin(balls::ballsOnFloor(), false)), device, 500);
    expectSameCrossings(balls::ballsOnFloor(Material::AlphaMode::Mask), device, 500);
}

/// Through each kind of glass at a slant, and through all of them in turn.
TEST_F(DeviceGlassS35, ClosedForms)
{
    using namespace glass;
    const vec3 direction = glm::normalize(vec3(0.3f, 1.0f, -0.2f));
    const auto through = [&](Scene scene) {
        const Pair pair(std::move(scene), device);
        std::vector<Ray> rays;
        for (std::size_t i = 0; i < kRays; ++i) {
            const vec2 at = vec2(unitFloat(hashPcg(uint32_t(i))), unitFloat(hashPcg(uint32_t(i) + 7u * kRays))) - 0.5f;
            rays.push_back({vec3(at.x, 0, at.y), 0.0f, direction, kInfinity});
        }
        std::vector<vec3> passed(kRays);
        EXPECT_TRUE(pair.gpu.kernels().transmittance(rays, passed));
        std::sort(passed.begin(), passed.end(), [](vec3 a, vec3 b) { return a.x < b.x; });
        EXPECT_LT(glm::distance(passed[kRays / 1000], passed[kRays - kRays / 1000]), 1.0e-5f);
        return passed[kRays / 2];
    };
    Scene all;
    vec3 product(1.0f);
    float height = 1.0f;
    for (const Glass kind : {Glass::Quad, Glass::Pane, Glass::Box, Glass::Thin}) {
        Scene scene;
        addGlass(scene, kind, 1.0f, 20.0f);
        expectColor(through(std::move(scene)), expectedOf(kind, direction.y), 1.0e-4f);
        addGlass(all, kind, height++, 20.0f);
        product *= expectedOf(kind, direction.y);
    }
    expectColor(through(std::move(all)), product, 2.0e-4f);
}

/// The same bits again, whatever else is traced.
TEST_F(DeviceGlassS35, RaysRepeatTheirBits)
{
    const Pair pair(glassCourt(), device);
    const std::vector<Ray> rays = courtRays(kInfinity);
    std::vector<RayHit> a(kRays);
    std::vector<RayHit> b(kRays / 2);
    ASSERT_TRUE(pair.gpu.kernels().nearest(rays, a, RayUse::Light));
    ASSERT_TRUE(pair.gpu.kernels().nearest(std::span(rays).last(kRays / 2), b, RayUse::Light));
    EXPECT_EQ(std::memcmp(a.data() + kRays / 2, b.data(), b.size() * sizeof(RayHit)), 0);
}

IntegrationSettings settingsOf(IntegratorKind kind, uint32_t seed = 1)
{
    IntegrationSettings settings;
    settings.samples = 48;
    settings.integrator = kind;
    settings.seed = seed;
    return settings;
}
void expectSame(const Scene& scene, const std::shared_ptr<BakeDevice>& device, int page)
{
    for (const IntegratorKind kind : {IntegratorKind::Cache, IntegratorKind::Path}) {
        SCOPED_TRACE(kind == IntegratorKind::Path ? "whole paths" : "gather");
        expectSameLight(lightOn(embreeIntegrators(), scene, page, settingsOf(kind)),
                        lightOn(gpuIntegrators(device), scene, page, settingsOf(kind)), 1.0e-3f);
    }
}

/// Mean light of the scene's texels.
vec3 meanOn(const IntegratorFactory& factory, const Scene& scene, int page, const IntegrationSettings& settings)
{
    vec3 sum(0.0f);
    const std::vector<IrradianceEstimate> light = lightOn(factory, scene, page, settings);
    for (const IrradianceEstimate& texel : light) sum += texel.irradiance;
    return sum / float(light.size());
}

/// Chance lets other rays pass: the mean over seeds is the same, by Student's t.
void expectSameMean(const Scene& scene, const std::shared_ptr<BakeDevice>& device, int page)
{
    for (const IntegratorKind kind : {IntegratorKind::Cache, IntegratorKind::Path}) {
        SCOPED_TRACE(kind == IntegratorKind::Path ? "whole paths" : "gather");
        std::array<std::vector<double>, 3> differences;
        vec3 mean(0.0f);
        for (uint32_t seed = 1; seed <= kSeeds; ++seed) {
            const vec3 cpu = meanOn(embreeIntegrators(), scene, page, settingsOf(kind, seed));
            const vec3 gpu = meanOn(gpuIntegrators(device), scene, page, settingsOf(kind, seed));
            mean += cpu / float(kSeeds);
            for (int c = 0; c < 3; ++c) differences[std::size_t(c)].push_back(double(gpu[c] - cpu[c]));
        }
        EXPECT_GT(mean.x, 1.2f * mean.z) << "the light has no colour";
        for (int c = 0; c < 3; ++c) {
            const SeedMean d = meanOf(differences[std::size_t(c)]);
            EXPECT_LE(std::abs(d.mean), 5.0 * d.error + 1.0e-4 * double(mean[c])) << c;
            EXPECT_LE(d.error, 0.01 * double(mean[c])) << c;
            std::cout << "    " << c << ": differs by " << 100.0 * d.mean / double(mean[c]) << " % of the mean, t "
                      << d.mean / d.error << "\n";
        }
    }
}

Scene lit(Scene scene, bool sky)
{
    if (sky) {
        scene.sky = skyOf(sunPicture(64, vec3(0.4f, 1, 0.6f), 0.15f, 200.0f), 0.7f);
        return scene;
    }
    scene.lights.push_back(bakedLight(LightType::Directional, vec3(0), vec3(0.3f, -1, -0.2f), 4.0f));
    scene.lights.back().angularRadiusRadians = 0.05f;
    scene.lights.push_back(bakedLight(LightType::Point, vec3(0.7f, 2.9f, -0.5f), vec3(0, -1, 0), 9.0f));
    scene.lights.back().shadowStrength = 0.6f;
    return scene;
}

TEST_F(DeviceGlassS35, LightUnderClearGlassIsTheProcessors)
{
    for (const bool sky : {false, true}) expectSame(lit(clearCourt(), sky), device, kCourtPage);
}
TEST_F(DeviceGlassS35, LightUnderGlassHasTheProcessorsMean)
{
    for (const bool sky : {false, true}) expectSameMean(lit(glassCourt(), sky), device, kCourtPage);
}

/// Emitters above the glass, which rays hit and samples choose. They outweigh all other light.
TEST_F(DeviceGlassS35, LightOfEmittersBehindGlass)
{
    for (const bool clear : {true, false}) {
        Scene scene = clear ? clearCourt() : glassCourt();
        for (Material& material : scene.materials)
            if (!material.isBlended()) material.baseColor *= vec4(0.5f, 0.5f, 0.5f, 1.0f);
        const int plain = addMaterial(scene, vec3(0.2f), vec3(9.0f, 8.0f, 6.0f));
        addRectangle(scene, {vec3(-1.6f, 2.95f, -1.6f), vec3(3.2f, 0, 0), vec3(0, 0, 3.2f)}, plain, kCourtPage, {}, 3);
        if (clear)
            expectSame(scene, device, kCourtPage);
        else
            expectSameMean(scene, device, kCourtPage);
    }
}

/// Walls with lightmaps: patches, links and secondary sources beyond a pane.
TEST_F(DeviceGlassS35, LightInARoomWithGlass)
{
    for (const bool lamp : {false, true}) {
        Scene scene = room(lamp, !lamp, !lamp);
        addRectangle(scene, {vec3(-0.2f, 0.1f, 0.9f), vec3(0.3f, 0, -1.6f), vec3(0, 1.5f, 0)}, addClearGlass(scene),
                     64);
        expectSame(scene, device, 64);
    }
}

/// Masks and channels of lights, by the rays of a device.
TEST_F(DeviceGlassS35, ColoredMasksAreClosedForms)
{
    using namespace glass;
    for (const Glass kind : {Glass::Quad, Glass::Pane, Glass::Box, Glass::Thin}) {
        Scene scene = floorUnderSun();
        addGlass(scene, kind, kHeight, 20.0f);
        ColoredBench bench(std::move(scene), MixedLightingMode::Shadowmask, gpuIntegrators(device));
        EXPECT_TRUE(bench.scene.lights[0].baking.coloredMask);
        for (const vec4& mask : bench.shadowmask()) {
            expectColor(vec3(mask), expectedOf(kind, -kSlanted.y));
            EXPECT_EQ(mask.w, 1.0f);
        }
    }
}

/// A sun's coloured mask and the baked light of a lamp, at edges too. Rays are nearly as many: chance decides at the
/// standing box which points are valid.
TEST_F(DeviceGlassS35, MasksAndDirectLightAreTheProcessors)
{
    Scene scene = glassCourt();
    scene.lights.push_back(bakedLight(LightType::Directional, vec3(0), vec3(0.3f, -1, -0.2f), 4.0f));
    scene.lights.back().angularRadiusRadians = 0.03f;
    scene.lights.push_back(
        makeLight(LightType::Point, vec3(0.7f, 2.9f, -0.5f), vec3(0, -1, 0), 9.0f, LightMode::Baked));
    glass::ColoredBench cpu(scene, MixedLightingMode::Shadowmask, embreeIntegrators(), kCourtPage);
    glass::ColoredBench gpu(scene, MixedLightingMode::Shadowmask, gpuIntegrators(device), kCourtPage);
    ASSERT_TRUE(gpu.scene.lights[0].baking.coloredMask);
    const uint64_t before = cpu.integrator->raysTraced();
    const uint64_t beforeGpu = gpu.integrator->raysTraced();
    const std::vector<vec4> a = cpu.shadowmask();
    const std::vector<vec4> b = gpu.shadowmask();
    const auto rays = double(cpu.integrator->raysTraced() - before);
    EXPECT_NEAR(double(gpu.integrator->raysTraced() - beforeGpu), rays, 0.02 * rays);
    std::size_t other = 0;
    std::size_t colored = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        other += glm::distance(a[i], b[i]) > 1.0f / 255.0f ? 1 : 0;
        colored += isGray(vec3(a[i])) ? 0 : 1;
    }
    EXPECT_GT(colored, a.size() / 4);
    EXPECT_LE(other, a.size() / 50);
    const std::vector<IrradianceEstimate> light = cpu.irradiance();
    const std::vector<IrradianceEstimate> lightOfGpu = gpu.irradiance();
    other = 0;
    for (std::size_t i = 0; i < light.size(); ++i)
        other += glm::distance(light[i].direct, lightOfGpu[i].direct) > 1.0e-3f * (luminance(light[i].direct) + 1.0e-3f)
                     ? 1
                     : 0;
    EXPECT_LE(other, light.size() / 50);
}

} // namespace
} // namespace halflight::test::device_glass_test
