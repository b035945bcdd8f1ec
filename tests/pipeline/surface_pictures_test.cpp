// Pictures of lit surfaces: a plane under a sun, of known radiance.

#include "pipeline/floor.h"

#include "halflight/bake/bake.h"
#include "halflight/bake_cpu/embree_integrator.h"
#include "halflight/bake_cpu/surface_pictures.h"
#include "halflight/shading/brdf.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

namespace halflight::surface_pictures_test {
namespace {

constexpr float kSunLux = 10.0f;
constexpr float kAlbedo = 0.5f;

/// A floor of 4 m under a sun at the zenith, in the left half of the texture white, in the right half black.
Scene makeFloor(bool textured)
{
    Scene scene;
    Material material;
    material.baseColor = vec4(vec3(kAlbedo), 1.0f);
    material.metallic = 0.0f;
    if (textured) {
        Texture texture;
        texture.pixels = ImageRgba8(256, 256, u8vec4(255));
        for (int y = 0; y < 256; ++y) {
            for (int x = 128; x < 256; ++x) texture.pixels.edit()(x, y) = u8vec4(0, 0, 0, y < 128 ? 255 : 0);
        }
        scene.textures.push_back(std::move(texture));
        material.baseColorTexture.texture = 0;
        material.alphaMode = Material::AlphaMode::Mask;
    }
    scene.materials.push_back(material);
    test::addFloor(scene, 2.0f);
    Light sun;
    sun.name = "sun";
    sun.type = LightType::Directional;
    sun.worldFromLight = glm::inverse(glm::lookAt(vec3(0, 1, 0), vec3(0), vec3(0, 0, 1)));
    sun.intensity = kSunLux;
    sun.mode = LightMode::Baked;
    scene.lights.push_back(sun);
    return scene;
}

BakeResult bakeFloor(Scene scene)
{
    BakeSettings settings;
    settings.mode = MixedLightingMode::BakedIndirect;
    settings.quality = Quality::Preview;
    settings.texelsPerMeter = 8.0f;
    settings.samples = 16;
    auto result = bake(std::move(scene), settings, embreeIntegrators());
    EXPECT_TRUE(result) << result.error().text();
    return std::move(*result);
}

/// The picture at a point of the floor, in its own coordinates from -2 to 2.
vec4 at(const BakeResult& result, const ImageRgba32f& page, vec2 place)
{
    const Object& floor = result.baked.scene.objects[0];
    const MeshPart& part = result.baked.scene.meshes[0].parts[0];
    // Vertices are copies of the source's; the corners tell the affine map.
    vec2 corner[3] = {};
    for (std::size_t i = 0; i < part.positions.size(); ++i) {
        const vec2 uv = floor.lightmap.scale * part.lightmapUv[i] + floor.lightmap.offset;
        if (part.positions[i] == vec3(-2, 0, 2)) corner[0] = uv;
        if (part.positions[i] == vec3(2, 0, 2)) corner[1] = uv;
        if (part.positions[i] == vec3(-2, 0, -2)) corner[2] = uv;
    }
    const vec2 weights((place.x + 2.0f) / 4.0f, (2.0f - place.y) / 4.0f);
    const vec2 uv = corner[0] + weights.x * (corner[1] - corner[0]) + weights.y * (corner[2] - corner[0]);
    return page(int(uv.x * float(page.width())), int(uv.y * float(page.height())));
}

TEST(SurfacePictures, HoldLightTimesAlbedoOverPi)
{
    const BakeResult result = bakeFloor(makeFloor(false));
    for (const int scale : {1, 4}) {
        const auto pictures = surfacePictures(result.baked.scene, result.irradiance, scale);
        ASSERT_TRUE(pictures);
        ASSERT_EQ(pictures->size(), 1u);
        EXPECT_EQ((*pictures)[0].width(), scale * result.report.pageSize);
        for (const vec2 place : {vec2(0.0f), vec2(-1.9f, 1.9f), vec2(1.3f, -0.7f)}) {
            const vec4 texel = at(result, (*pictures)[0], place);
            for (int c = 0; c < 3; ++c) EXPECT_NEAR(texel[c], kAlbedo * kSunLux / kPi, 0.01f * kSunLux / kPi);
            EXPECT_EQ(texel.w, 1.0f);
        }
    }
}

TEST(SurfacePictures, ShowTexturesFinerThanTheLightmapAndTheirHoles)
{
    const BakeResult result = bakeFloor(makeFloor(true));
    const auto pictures = surfacePictures(result.baked.scene, result.irradiance, 4);
    ASSERT_TRUE(pictures);
    const ImageRgba32f& page = (*pictures)[0];
    const float step = 1.0f / 16.0f; // two of the picture's texels, half of one of the lightmap's
    EXPECT_NEAR(at(result, page, {-step, -1.0f}).x, kAlbedo * kSunLux / kPi, 0.02f);
    EXPECT_NEAR(at(result, page, {step, -1.0f}).x, 0.0f, 0.02f);
    EXPECT_EQ(at(result, page, {step, -1.0f}).w, 1.0f);
    EXPECT_EQ(at(result, page, {1.0f, 1.0f}).w, 0.0f) << "cut out";
    EXPECT_NEAR(at(result, page, {-1.0f, 1.0f}).w, 1.0f, 0.0f);
}

TEST(SurfacePictures, AreExposedAndClampedAsSrgb)
{
    ImageRgba32f picture(4, 1);
    picture(0, 0) = vec4(0.5f, 1.0f, 2.0f, 1.0f);
    picture(1, 0) = vec4(4.0f, 8.0f, 16.0f, 0.5f);
    picture(2, 0) = vec4(0.0f, 0.0f, 0.0f, 1.0f);
    const auto encoded = [](double linear) {
        return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
    };
    const DisplayedSurfaces displayed = displayedSurfaces({picture}, 2.0f);
    ASSERT_EQ(displayed.pages.size(), 1u);
    const ImageRgba8& page = displayed.pages[0];
    EXPECT_NEAR(page(0, 0).x, 255.0 * encoded(0.125), 1.0);
    EXPECT_NEAR(page(0, 0).z, 255.0 * encoded(0.5), 1.0);
    EXPECT_EQ(page(1, 0), u8vec4(255, 255, 255, 128));
    EXPECT_EQ(page(2, 0), u8vec4(0, 0, 0, 255));
    EXPECT_EQ(page(3, 0), u8vec4(0)) << "no surface";
    EXPECT_NEAR(displayed.clipped, 1.0 / 3.0, 1.0e-9);
    EXPECT_EQ(displayedSurfaces({picture}, 2.0f, 4.0f).clipped, 0.0);
    EXPECT_EQ(displayedSurfaces({picture}, 2.0f, 4.0f).pages[0](1, 0).z, 255);
    EXPECT_FLOAT_EQ(surfaceStrength({picture}, 2.0f), 1.0f) << "all but the brightest texel of three";
    ImageRgba32f ramp(1000, 1);
    for (int x = 0; x < 1000; ++x) ramp(x, 0) = vec4(0.0f, float(x + 1), 0.0f, 1.0f);
    EXPECT_NEAR(std::exp2(surfaceExposure({ramp})), 950.0f, 1.5f);
    EXPECT_NEAR(displayedSurfaces({ramp}, surfaceExposure({ramp})).clipped, 0.05, 0.002);
    EXPECT_NEAR(surfaceStrength({ramp}, 8.0f), 999.0f / 256.0f, 0.01f);
    EXPECT_FLOAT_EQ(surfaceStrength({ramp}, 0.0f), 16.0f);
}

} // namespace
} // namespace halflight::surface_pictures_test
