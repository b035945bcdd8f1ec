// Paths on a device bring the light that they bring on the processor (spec S6): continuation paths of gather rays, and
// the whole ones of path-traced bakes. All but the floor has no lightmap here, so that nearly all gather rays go on as
// paths. Both sides take the same samples: but for rounding, texels are the same.

#include "bake/area_light_scene.h"
#include "bake/geometry/balls.h"
#include "bake/test_sky.h"
#include "bake_gpu/court.h"
#include "bake_gpu/same_light.h"
#include "transport/trace/device_paths.h"

namespace halflight::test::paths_test {
namespace {

using DevicePathsS6 = BakeDeviceTest;

constexpr int kPage = kCourtPage;

IntegrationSettings settingsOf(int bounces = kAllBounces)
{
    IntegrationSettings settings;
    settings.samples = 48;
    settings.bounces = bounces;
    return settings;
}

void expectSame(const Scene& scene, const std::shared_ptr<BakeDevice>& device,
                const IntegrationSettings& settings = settingsOf(), int page = kPage, uint32_t step = 1,
                float near = 1.0e-3f)
{
    for (const IntegratorKind kind : {IntegratorKind::Cache, IntegratorKind::Path}) {
        SCOPED_TRACE(kind == IntegratorKind::Path ? "whole paths" : "continuation paths");
        IntegrationSettings of = settings;
        of.integrator = kind;
        expectSameLight(lightOn(embreeIntegrators(), scene, page, of, step),
                        lightOn(gpuIntegrators(device), scene, page, of, step), near);
    }
}

TEST_F(DevicePathsS6, SunLampAndSpot)
{
    Scene scene = court();
    scene.lights.push_back(bakedLight(LightType::Directional, vec3(0), vec3(0.5f, -1, -0.4f), 4.0f));
    scene.lights.back().angularRadiusRadians = 0.05f;
    scene.lights.push_back(bakedLight(LightType::Point, vec3(1, 1.5f, 0.5f), vec3(0, -1, 0), 2.0f));
    scene.lights.back().radiusMeters = 0.2f;
    scene.lights.push_back(bakedLight(LightType::Spot, vec3(-1, 2.5f, 1), vec3(0.2f, -0.5f, -1), 9.0f));
    scene.lights.back().indirectMultiplier = 2.0f;
    scene.lights.push_back(bakedLight(LightType::Point, vec3(0, 0.7f, -1.5f), vec3(0, -1, 0), 0.5f));
    scene.lights.back().shadowStrength = 0.5f;
    expectSame(scene, device);
    expectSame(scene, device, settingsOf(2)); // levels of the radiance cache
    IntegrationSettings diffuse = settingsOf();
    diffuse.glossyBounces = false;
    expectSame(scene, device, diffuse);
}

TEST_F(DevicePathsS6, AreaLights)
{
    Scene scene = court();
    for (const LightType type : {LightType::Rectangle, LightType::Disk})
        scene.lights.push_back(areaLight(type, vec3(type == LightType::Disk ? 1.0f : -1.0f, 2.6f, 0.5f),
                                         vec3(0.1f, -1, -0.3f), vec2(0.8f, 0.5f), 20.0f, LightMode::Mixed));
    // Steradians are a difference of angles, and Vulkan's arc cosines are inexact.
    expectSame(scene, device, settingsOf(), kPage, 1, 5.0e-3f);
}

/// More than eight lights are in a tree, and some end before the place.
TEST_F(DevicePathsS6, ManyLamps)
{
    Scene scene = court();
    for (int i = 0; i < 20; ++i)
        scene.lights.push_back(pointAt("lamp", vec3(-1.7f + 0.18f * float(i), 0.3f + 0.13f * float(i), 1.6f),
                                       i % 3 == 0 ? 1.5f : 8.0f, 0.4f + 0.1f * float(i % 4)));
    expectSame(scene, device);
}

/// A sun in the sky's picture is sampled as a light.
TEST_F(DevicePathsS6, SkyWithASun)
{
    Scene scene = court();
    scene.sky = skyOf(sunPicture(64, vec3(0.4f, 1, 0.6f), 0.15f, 200.0f), 0.7f);
    expectSame(scene, device);
}

/// Emitters with and without a picture, from one or both sides, with holes, and one that casts no shadow. Light from
/// them outweighs all other at every place, so that none of their samples are left out, on either side.
TEST_F(DevicePathsS6, Emitters)
{
    Scene scene = court();
    for (Material& material : scene.materials) material.baseColor *= vec4(0.5f, 0.5f, 0.5f, 1.0f);
    const int picture = addMaterialWithHoles(scene, vec3(0.2f), ImageRgba8(4, 4, u8vec4(255)), true);
    Texture& holes = scene.textures.back();
    ImageRgba8 pixels(4, 4, u8vec4(200, 180, 90, 255));
    for (int y = 0; y < 4; ++y) pixels(1, y).w = 0;
    holes.pixels = std::move(pixels);
    scene.materials[std::size_t(picture)].emissiveNits = vec3(12.0f);
    scene.materials[std::size_t(picture)].emissiveTexture = {.texture = 0};
    addPlates(scene, picture);
    expectSame(scene, device);
}

/// Turned, stretched and mirrored instances of a mesh, without lightmaps.
TEST_F(DevicePathsS6, Instances)
{
    Scene scene = balls::ballsOnFloor();
    for (Object& object : scene.objects)
        if (&object != &scene.objects.front()) object.lightmap.page = -1;
    scene.textures = {colors(8)};
    scene.materials[1].baseColorTexture = {.texture = 0};
    for (Mesh& mesh : scene.meshes)
        for (MeshPart& part : mesh.parts) {
            part.uv[0].clear();
            for (const vec3 p : part.positions) part.uv[0].emplace_back(p.x + 0.3f * p.z, p.y);
        }
    expectSame(scene, device, settingsOf(), balls::kPage, 41);
}

/// Direct light alone, of texels and by a path that sees a lamp's surface by chance.
TEST_F(DevicePathsS6, WithoutBounces)
{
    Scene scene = court();
    const int plain = addMaterial(scene, vec3(0.2f), vec3(9.0f, 8.0f, 6.0f));
    addRectangle(scene, {vec3(-0.8f, 2.9f, -1), vec3(1.6f, 0, 0), vec3(0, 0, 1)}, plain, kPage);
    scene.sky = skyOf(sunPicture(64, vec3(0.4f, 1, 0.6f), 0.15f, 200.0f), 0.7f);
    IntegrationSettings settings = settingsOf(0);
    settings.integrator = IntegratorKind::Path;
    expectSameLight(lightOn(embreeIntegrators(), scene, kPage, settings),
                    lightOn(gpuIntegrators(device), scene, kPage, settings), 1.0e-3f);
}

/// A texel has more paths than a call.
TEST_F(DevicePathsS6, ManyPathsOfATexel)
{
    Scene scene;
    addRectangle(scene, {vec3(-1, 0, 1), vec3(2, 0, 0), vec3(0, 0, -2)}, addMaterial(scene, vec3(0.5f)), kPage,
                 {vec2(2), vec2(30)});
    scene.sky = {vec3(1.0f, 0.5f, 0.2f), vec3(0.6f), vec3(0.2f)};
    IntegrationSettings settings = settingsOf();
    settings.integrator = IntegratorKind::Path;
    settings.samples = int(DevicePaths::kMostPaths) + 1000;
    const auto cpu = lightOn(embreeIntegrators(), scene, kPage, settings, 500);
    const auto gpu = lightOn(gpuIntegrators(device), scene, kPage, settings, 500);
    ASSERT_EQ(gpu.size(), 2u);
    for (std::size_t i = 0; i < gpu.size(); ++i) {
        EXPECT_EQ(gpu[i].samples, uint32_t(settings.samples));
        EXPECT_GT(cpu[i].irradiance.x, 1.0f);
        EXPECT_LT(glm::distance(gpu[i].irradiance, cpu[i].irradiance), 1.0e-4f * cpu[i].irradiance.x);
        EXPECT_NEAR(gpu[i].varianceOfMean, cpu[i].varianceOfMean, 1.0e-3f * cpu[i].varianceOfMean);
    }
}

/// The same bits again, whatever else is asked for.
TEST_F(DevicePathsS6, BytesRepeat)
{
    Scene scene = court();
    scene.lights.push_back(bakedLight(LightType::Directional, vec3(0), vec3(0.5f, -1, -0.4f), 4.0f));
    scene.sky = skyOf(sunPicture(64, vec3(0.4f, 1, 0.6f), 0.15f, 200.0f));
    for (const IntegratorKind kind : {IntegratorKind::Cache, IntegratorKind::Path}) {
        IntegrationSettings settings = settingsOf();
        settings.integrator = kind;
        const auto all = lightOn(gpuIntegrators(device), scene, kPage, settings, 1);
        const auto some = lightOn(gpuIntegrators(device), scene, kPage, settings, 5);
        for (std::size_t i = 0; i < some.size(); ++i) {
            EXPECT_EQ(some[i].irradiance, all[5 * i].irradiance);
            EXPECT_EQ(some[i].moment, all[5 * i].moment);
        }
    }
}

} // namespace
} // namespace halflight::test::paths_test
