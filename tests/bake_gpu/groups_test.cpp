// Light groups on a device (spec S33): the light of each component is the processor's. Both take the same samples: but
// for rounding, texels and probes are the same.

#include "bake/test_room.h"
#include "bake/test_sky.h"
#include "bake_gpu/glass_court.h"
#include "bake_gpu/same_light.h"

#include "halflight/scene/light_groups.h"

#include <numeric>

namespace halflight::test::groups_test {
namespace {

using DeviceGroupsS33 = BakeDeviceTest;

/// All of it is the rest at first.
LightComponents componentsOf(const Scene& scene, int count)
{
    return {count, std::vector<int>(scene.lights.size()), std::vector<int>(scene.materials.size()), {0, 0, 0}};
}

IntegrationSettings settingsOf(const LightComponents& components)
{
    IntegrationSettings settings;
    settings.samples = 48;
    settings.bounces = 4;
    settings.components = components;
    return settings;
}

/// Light of texels: in all, and of each component.
struct ByComponent {
    std::vector<IrradianceEstimate> all;
    std::vector<std::vector<IrradianceEstimate>> of;
    uint64_t rays = 0;
};

/// Every n-th texel of a scene.
ByComponent bakeOn(const IntegratorFactory& factory, const Scene& scene, int page, const IntegrationSettings& settings,
                   uint32_t step = 1)
{
    Bench bench(scene, MixedLightingMode::Shadowmask, page, settings, 1, factory);
    const auto count = std::size_t(settings.components.count);
    std::vector<uint32_t> texels;
    for (uint32_t i = 0; i < bench.map.texels.size(); i += step) texels.push_back(i);
    ByComponent light{std::vector<IrradianceEstimate>(texels.size()), {}};
    std::vector<IrradianceEstimate> components(texels.size() * count);
    const uint64_t before = bench.integrator->raysTraced();
    bench.lightmap = bench.integrator->prepare(bench.map, nullptr);
    EXPECT_TRUE(bench.lightmap->irradianceByComponent({texels}, light.all, components, {}));
    light.rays = bench.integrator->raysTraced() - before;
    light.of.resize(count);
    for (std::size_t i = 0; i < components.size(); ++i) light.of[i % count].push_back(components[i]);
    return light;
}

void expectSame(const Scene& scene, int page, const std::shared_ptr<BakeDevice>& device,
                const IntegrationSettings& settings, float near = 1.0e-3f)
{
    const ByComponent cpu = bakeOn(embreeIntegrators(), scene, page, settings);
    const ByComponent gpu = bakeOn(gpuIntegrators(device), scene, page, settings);
    EXPECT_NEAR(double(gpu.rays), double(cpu.rays), 1.0e-3 * double(cpu.rays));
    expectSameLight(cpu.all, gpu.all, near);
    for (std::size_t c = 0; c < cpu.of.size(); ++c) {
        SCOPED_TRACE("component " + std::to_string(c));
        expectSameLight(cpu.of[c], gpu.of[c], near);
        for (std::size_t i = 0; i < cpu.of[c].size(); i += 50) {
            const float variance = cpu.of[c][i].varianceOfMean;
            EXPECT_NEAR(gpu.of[c][i].varianceOfMean, variance, 0.1f * variance + 1.0e-7f);
        }
    }
}

/// Both integrators: texels of the one are path traced from the start.
void expectSameOfBoth(const Scene& scene, int page, const std::shared_ptr<BakeDevice>& device,
                      IntegrationSettings settings)
{
    for (const IntegratorKind kind : {IntegratorKind::Cache, IntegratorKind::Path}) {
        SCOPED_TRACE(kind == IntegratorKind::Path ? "whole paths" : "gather");
        settings.integrator = kind;
        expectSame(scene, page, device, settings);
    }
}

/// A lamp, a sun, a lamp of no group, and a gradient whose colours are three components.
TEST_F(DeviceGroupsS33, RoomsHaveTheProcessorsLight)
{
    const Scene scene = room(true, true, true);
    LightComponents components = componentsOf(scene, 6);
    components.ofLight = {1, 0};
    components.ofMaterial[2] = 2;
    components.ofSky = {3, 4, 5};
    expectSameOfBoth(scene, 64, device, settingsOf(components));
}

/// The same with a pane in the room's middle. All light that passes it takes its colour, in each component.
TEST_F(DeviceGroupsS33, LightThroughColoredGlassS35)
{
    Scene scene = room(true, true, true);
    addRectangle(scene, {vec3(-0.2f, 0.1f, 0.9f), vec3(0.3f, 0, -1.6f), vec3(0, 1.5f, 0)}, addClearGlass(scene), 64);
    LightComponents components = componentsOf(scene, 6);
    components.ofLight = {1, 0};
    components.ofMaterial[2] = 2;
    components.ofSky = {3, 4, 5};
    expectSameOfBoth(scene, 64, device, settingsOf(components));
}

/// Plates under the room's ceiling: all of the rest, but for those of one component whose light is a twentieth.
void addCeilingPlates(Scene& scene, LightComponents& components, float nits, int component)
{
    for (int i = 0; i < 40; ++i) {
        const int material = addMaterial(scene, vec3(0.0f), (i % 2 == 0 ? nits : 0.05f * nits) * vec3(1, 2, 3));
        components.ofMaterial.push_back(i % 2 == 0 ? 0 : component);
        const vec3 corner(-0.9f + 0.22f * float(i % 8), 1.9f, -0.9f + 0.3f * float(i / 8));
        addRectangle(scene, {corner, vec3(0.1f, 0, 0), vec3(0, 0, 0.1f)}, material, 64);
    }
}

/// Plates and a sun in the sky's picture, of several components, share the samples.
TEST_F(DeviceGroupsS33, PlatesAndASunInTheSky)
{
    Scene scene = room(false, true, false);
    LightComponents components = componentsOf(scene, 5);
    components.ofLight = {1, 2};
    addCeilingPlates(scene, components, 4.0f, 3);
    scene.sky = skyOf(sunPicture(64, vec3(0.6f, 0.8f, 0.5f), 0.15f, 200.0f), 0.2f);
    components.ofSky = {4, 4, 4};
    expectSame(scene, 64, device, settingsOf(components));
}

/// Beside a bright sun, roulette leaves out most samples of dim plates. A component has all of them.
TEST_F(DeviceGroupsS33, DimPlatesBesideASun)
{
    Scene scene = room(false, true, true);
    LightComponents components = componentsOf(scene, 3);
    components.ofLight = {1, 1};
    addCeilingPlates(scene, components, 5.0f, 2);
    for (Light& light : scene.lights) light.intensity *= 50.0f;
    components.ofSky = {1, 1, 1};
    expectSame(scene, 64, device, settingsOf(components));
    const ByComponent together = bakeOn(gpuIntegrators(device), scene, 64, settingsOf(componentsOf(scene, 0)));
    EXPECT_GT(bakeOn(gpuIntegrators(device), scene, 64, settingsOf(components)).rays, together.rays * 11 / 10);
}

/// Lamps, among them so many of a component that they are in a tree, plates and a sky in a court whose surfaces reflect
/// in different ways; nearly all gather rays go on as paths.
Scene courtWithLamps(LightComponents& components)
{
    Scene scene = court();
    for (Material& material : scene.materials) material.baseColor *= vec4(0.5f, 0.5f, 0.5f, 1.0f);
    const int picture = addMaterial(scene, vec3(0.2f), vec3(12.0f), true);
    scene.materials[std::size_t(picture)].emissiveTexture = {.texture = 0};
    addPlates(scene, picture);
    for (int i = 0; i < 24; ++i)
        scene.lights.push_back(pointAt("lamp", vec3(-1.7f + 0.14f * float(i), 0.3f + 0.1f * float(i), 1.6f),
                                       i % 3 == 0 ? 1.5f : 8.0f, 0.4f + 0.1f * float(i % 4)));
    scene.lights.push_back(bakedLight(LightType::Directional, vec3(0), vec3(0.5f, -1, -0.4f), 4.0f));
    scene.sky = {vec3(1.0f), vec3(0.6f), vec3(0.2f)};
    components = componentsOf(scene, 6);
    for (std::size_t i = 0; i < 24; ++i) components.ofLight[i] = i < 12 ? 1 : i < 20 ? 2 : 0;
    components.ofLight[24] = 3;
    components.ofMaterial[std::size_t(picture)] = 4;
    components.ofMaterial.back() = 5;
    components.ofSky = {0, 0, 5};
    return scene;
}

TEST_F(DeviceGroupsS33, PathsHaveTheProcessorsLight)
{
    LightComponents components;
    const Scene scene = courtWithLamps(components);
    expectSameOfBoth(scene, kCourtPage, device, settingsOf(components));
    IntegrationSettings few = settingsOf(components); // levels of the radiance cache
    few.bounces = 2;
    few.glossyBounces = false;
    expectSame(scene, kCourtPage, device, few);
}

/// As many groups as a file may have. A call takes fewer blocks, and several launches trace the paths.
TEST_F(DeviceGroupsS33, SixteenGroups)
{
    Scene scene = court();
    for (int i = 0; i <= int(kMostLightGroups); ++i)
        scene.lights.push_back(
            pointAt("lamp", vec3(-1.7f + 0.2f * float(i), 0.5f + 0.1f * float(i), 1.2f), 8.0f, 2.0f));
    LightComponents components = componentsOf(scene, int(kMostLightGroups) + 1);
    std::iota(components.ofLight.begin(), components.ofLight.end(), 0);
    IntegrationSettings settings = settingsOf(components);
    settings.samples = 1800;
    expectSame(scene, kCourtPage, device, settings);
}

/// The same bits, whether one asks for all texels or for some.
TEST_F(DeviceGroupsS33, BytesRepeat)
{
    LightComponents components;
    const Scene scene = courtWithLamps(components);
    for (const IntegratorKind kind : {IntegratorKind::Cache, IntegratorKind::Path}) {
        IntegrationSettings settings = settingsOf(components);
        settings.integrator = kind;
        const ByComponent all = bakeOn(gpuIntegrators(device), scene, kCourtPage, settings);
        const ByComponent some = bakeOn(gpuIntegrators(device), scene, kCourtPage, settings, 5);
        for (std::size_t c = 0; c < all.of.size(); ++c)
            for (std::size_t i = 0; i < some.all.size(); ++i) {
                EXPECT_EQ(some.of[c][i].irradiance, all.of[c][5 * i].irradiance);
                EXPECT_EQ(some.of[c][i].moment, all.of[c][5 * i].moment);
            }
    }
}

struct Probes {
    std::vector<ProbeEstimate> all;
    std::vector<SphericalHarmonicsL2> components;
};

Probes probesOn(const IntegratorFactory& factory, const Scene& scene, const IntegrationSettings& settings)
{
    Bench bench(scene, MixedLightingMode::Shadowmask, kCourtPage, settings, 1, factory);
    std::vector<vec3> places;
    for (int i = 0; i < 60; ++i)
        places.emplace_back(-1.8f + 0.9f * float(i % 5), 0.3f + 0.8f * float(i / 5 % 3), -1.7f + 1.1f * float(i / 15));
    Probes probes{std::vector<ProbeEstimate>(places.size()), {}};
    probes.components.resize(places.size() * std::size_t(settings.components.count));
    const std::vector<uint32_t> which = allIndices(places.size());
    EXPECT_TRUE(bench.integrator->probesByComponent(places, which, 64, probes.all, probes.components, {}));
    return probes;
}

TEST_F(DeviceGroupsS33, ProbesHaveTheProcessorsLight)
{
    LightComponents components;
    Scene scene = courtWithLamps(components);
    scene.lights[22].mode = LightMode::Baked;
    for (const bool picture : {false, true}) {
        if (picture) {
            scene.sky = skyOf(sunPicture(64, vec3(0.4f, 1, 0.6f), 0.15f, 200.0f), 0.7f);
            components.ofSky = {3, 3, 3};
        }
        const Probes cpu = probesOn(embreeIntegrators(), scene, settingsOf(components));
        const Probes gpu = probesOn(gpuIntegrators(device), scene, settingsOf(components));
        std::size_t other = 0;
        for (std::size_t i = 0; i < cpu.components.size(); ++i) {
            const float light = luminance(cpu.components[i][0]);
            EXPECT_GT(light, 0.0f);
            bool same = true;
            for (std::size_t b = 0; b < 9; ++b)
                same = same && glm::distance(cpu.components[i][b], gpu.components[i][b]) < 1.0e-3f * (light + 1.0e-3f);
            other += same ? 0 : 1;
        }
        // A number that falls on the other side of a threshold by rounding makes another path.
        EXPECT_LT(other, cpu.components.size() / 20);
        for (std::size_t i = 0; i < cpu.all.size(); ++i) EXPECT_EQ(cpu.all[i].valid, gpu.all[i].valid);
    }
}

} // namespace
} // namespace halflight::test::groups_test
