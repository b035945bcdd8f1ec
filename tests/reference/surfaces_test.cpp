// What the reference reads of materials: textures, normal maps, alpha, vertex colours; and its settings (spec S6).
#include "reference/traced.h"

#include "halflight/base/parallel.h"
#include "halflight/shading/color.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <string_view>
#include <thread>

namespace halflight::test::surfaces_test {
namespace {

const vec3 kUp(0, 1, 0);
const vec3 kView = glm::normalize(vec3(0.2f, 0.9f, 0.3f));
const vec3 kToSun = glm::normalize(vec3(-0.4f, 0.8f, 0.2f));
const Finish kFinish{vec3(0.8f, 0.6f, 0.3f), 0.4f, 0.4f, 1.0f};

Scene makeSunnyFloor(const Finish& f = kFinish)
{
    Scene scene;
    addFloor(scene, addFinish(scene, f));
    scene.lights.push_back(makeLight(LightType::Directional, vec3(0), -kToSun, 3.0f, LightMode::Realtime));
    return scene;
}

void expectNear(vec3 found, vec3 expected, float relative = 2e-3f)
{
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], expected[c], relative * expected[c] + 1e-5f) << c;
}

// Textures of any size are read at full resolution, bilinear, colours in linear light.
TEST(ReferenceMaterialsS6, TexturesAreSharpAndFiltered)
{
    Scene scene = makeSunnyFloor({vec3(1.0f), 0.0f, 1.0f, 0.0f});
    Texture stripes; // columns white and black
    stripes.pixels = ImageRgba8(1024, 4, u8vec4(255));
    for (int x = 1; x < 1024; x += 2)
        for (int y = 0; y < 4; ++y) stripes.pixels.edit()(x, y) = u8vec4(0, 0, 0, 255);
    scene.textures.push_back(stripes);
    scene.materials[0].baseColorTexture.texture = 0;
    const Traced traced(std::move(scene));
    const float texel = 4.0f / 1024.0f; // metres
    const float white = 3.0f * kToSun.y / kPi;
    for (const float place : {0.5f, 0.75f, 1.0f, 1.5f}) {                 // in texels
        const float share = std::max(0.0f, 1.5f - std::max(place, 0.5f)); // of the white column
        const vec3 found = traced.radiance(vec3(texel * place, 1.0f, 0.01f), -kUp, 1);
        EXPECT_NEAR(found.x, share * white, 2e-3f * white) << place;
    }
}

// Metallic and roughness are data, not colours: their bilinear mean is that of the stored values.
TEST(ReferenceMaterialsS6, MetallicAndRoughnessTextures)
{
    Scene scene = makeSunnyFloor({vec3(0.8f, 0.6f, 0.3f), 1.0f, 1.0f, 1.0f});
    Texture data;
    data.pixels = ImageRgba8(2, 1, u8vec4(0, 64, 255, 255));
    data.pixels.edit()(1, 0) = u8vec4(0, 192, 51, 255);
    data.wrapU = data.wrapV = Texture::Wrap::ClampToEdge;
    scene.textures.push_back(data);
    scene.materials[0].metallicRoughnessTexture.texture = 0;
    const Traced traced(std::move(scene));
    for (const float place : {-1.0f, 0.0f, 1.0f}) { // the columns' middles and between them
        const float t = 0.5f * (place + 1.0f);
        const Finish f{vec3(0.8f, 0.6f, 0.3f), glm::mix(255.0f, 51.0f, t) / 255.0f, glm::mix(64.0f, 192.0f, t) / 255.0f,
                       1.0f};
        expectNear(traced.radiance(vec3(place, 0, 0) + kView, -kView, 1),
                   reflectedBy(f, kUp, kView, kToSun, vec3(3.0f)));
    }
}

// A normal map, seen from both sides, on a mirrored object and with a scale.
TEST(ReferenceMaterialsS6, NormalMapsFollowTheTangents)
{
    for (const float mirror : {1.0f, -1.0f}) {
        for (const float side : {1.0f, -1.0f}) {
            for (const float scale : {1.0f, 0.5f}) {
                Scene scene = makeSunnyFloor();
                Material& material = scene.materials[0];
                material.doubleSided = true;
                material.normalScale = scale;
                Texture texture;
                texture.pixels = ImageRgba8(1, 1, u8vec4(204, 153, 230, 255));
                scene.textures.push_back(texture);
                material.normalTexture.texture = 0;
                MeshPart& part = scene.meshes[0].parts[0];
                part.tangents.assign(part.positions.size(), vec4(1, 0, 0, 1));
                scene.objects[0].worldFromObject = glm::scale(mat4(1.0f), vec3(mirror, 1, 1));
                const vec3 across(1, side, 1);
                scene.lights[0].worldFromLight = lightPose(vec3(0), -kToSun * across);
                // Normal +y, tangent +x, bitangent = normal x tangent = -z.
                const vec3 m = (vec3(204, 153, 230) / 255.0f * 2.0f - 1.0f) * vec3(scale, scale, 1);
                const vec3 normal = side * glm::normalize(vec3(mirror * m.x, m.z, -m.y));
                const vec3 view = kView * across;
                expectNear(Traced(std::move(scene)).atOrigin(view, 1),
                           reflectedBy(kFinish, normal, view, kToSun * across, vec3(3.0f)));
            }
        }
    }
}

// Light from below a triangle does not reach it, however far its normal map leans over.
TEST(ReferenceMaterialsS6, NoLightThroughTheSurface)
{
    Scene scene = makeSunnyFloor({vec3(0.8f), 0.0f, 0.5f, 1.0f});
    scene.textures.emplace_back();
    scene.textures[0].pixels = ImageRgba8(1, 1, u8vec4(250, 128, 140, 255)); // leans towards +x
    scene.materials[0].normalTexture.texture = 0;
    MeshPart& part = scene.meshes[0].parts[0];
    part.tangents.assign(part.positions.size(), vec4(1, 0, 0, 1));
    scene.lights[0].worldFromLight = lightPose(vec3(0), -glm::normalize(vec3(1.0f, -0.2f, 0.0f)));
    const int lamp = addMaterial(scene, vec3(0.0f), vec3(9.0f), true);
    addRectangle(scene, {vec3(1, -2, -1), vec3(0, 1.9f, 0), vec3(0, 0, 2)}, lamp, 1);
    scene.sky.ground = vec3(5.0f);
    EXPECT_EQ(Traced(scene).atOrigin(kView, 256, 2), vec3(0.0f));
    // Of an even sky a tilted diffuse surface has what its hemisphere and the triangle's share.
    scene.sky = {vec3(1.0f), vec3(1.0f), vec3(1.0f)};
    scene.materials[0].baseColor = vec4(1.0f);
    scene.materials[0].specular = 0.0f;
    const float tilt = glm::normalize(vec3(250, 128, 140) / 255.0f * 2.0f - 1.0f).z;
    EXPECT_NEAR(Traced(scene).atOrigin(kView, 4096, 4).x, 0.5f * (1.0f + tilt), 0.01f);
}

TEST(ReferenceMaterialsS6, MasksBlendsAndVertexColors)
{
    // A pane of alpha 0.25 above the floor, a mask with a hole on its left half.
    Scene scene = makeSunnyFloor();
    const Finish pane{vec3(0.1f, 0.2f, 0.9f), 0.0f, 0.6f, 1.0f};
    const int blend = addFinish(scene, pane);
    scene.materials.back().alphaMode = Material::AlphaMode::Blend;
    scene.materials.back().baseColor.w = 0.25f;
    addRectangle(scene, {vec3(-1, 0.5f, 1), vec3(2, 0, 0), vec3(0, 0, -2)}, blend, 1);
    scene.objects.back().castShadows = false;
    scene.meshes.back().parts[0].colors.assign(4, vec4(1.0f, 0.5f, 0.5f, 0.8f));
    const Traced traced(std::move(scene));
    Finish tinted = pane;
    tinted.color *= vec3(1.0f, 0.5f, 0.5f);
    const vec3 expected = glm::mix(reflectedBy(kFinish, kUp, kView, kToSun, vec3(3.0f)),
                                   reflectedBy(tinted, kUp, kView, kToSun, vec3(3.0f)), 0.25f * 0.8f);
    vec3 mean(0.0f); // over rays side by side: chance is by ray
    constexpr int kRays = 4000;
    for (int i = 0; i < kRays; ++i)
        mean += traced.radiance(kView + vec3(1e-4f * float(i), 0, 0), -kView, 1) / float(kRays);
    expectNear(mean, expected, 0.03f);

    Scene masked = makeSunnyFloor();
    ImageRgba8 pixels(2, 1, u8vec4(255));
    pixels(0, 0).w = 0;
    const int mask = addMaterialWithHoles(masked, vec3(0.0f), pixels);
    masked.materials.back().specular = 0.0f;
    addRectangle(masked, {vec3(-1, 0.5f, 1), vec3(2, 0, 0), vec3(0, 0, -2)}, mask, 1);
    masked.objects.back().castShadows = false;
    const Traced holes(std::move(masked));
    for (const float x : {-0.5f, 0.5f}) {
        const vec3 found = holes.radiance(vec3(x, 1, 0), -kUp, 1);
        expectNear(found, x < 0.0f ? reflectedBy(kFinish, kUp, kUp, kToSun, vec3(3.0f)) : vec3(0.0f));
    }
}

// Without specular lobes every surface is diffuse, of the albedo that the bake carries light on with.
TEST(ReferenceMaterialsS6, DiffuseSurfacesHaveTheTransportAlbedo)
{
    const Traced traced(makeSunnyFloor(), {ReferenceSurfaces::Diffuse});
    const vec3 albedo = shading::transportAlbedo(kFinish.color, kFinish.metallic, kFinish.roughness);
    expectNear(traced.atOrigin(kView, 1), albedo * 3.0f * kToSun.y / kPi);
}

// Behind the first surface, diffuse bounces: what a mirror shows of a metal is the metal's diffuse stand-in.
TEST(ReferenceMaterialsS6, DiffuseBouncesEndAtTheFirstSurface)
{
    Scene scene = makeSunnyFloor({vec3(1.0f), 1.0f, 0.0f, 1.0f});
    scene.lights[0].worldFromLight = lightPose(vec3(0), vec3(0, 1, 0)); // from below, on the ceiling alone
    scene.objects[0].castShadows = false;
    const Finish f{vec3(0.9f), 1.0f, 0.4f, 1.0f};
    addRectangle(scene, {vec3(-9, 3, -9), vec3(18, 0, 0), vec3(0, 0, 18)}, addFinish(scene, f), 1);
    const vec3 toCeiling = glm::reflect(-kView, kUp);
    const float albedo = shading::transportAlbedo(f.color, f.metallic, f.roughness).x;
    const float diffuse = Traced(scene, {ReferenceSurfaces::DiffuseBounces}).atOrigin(kView, 2048, 1).x;
    EXPECT_NEAR(diffuse, albedo * 3.0f / kPi, 0.01f);
    const float full = Traced(scene).atOrigin(kView, 2048, 1).x;
    EXPECT_NEAR(full, reflectedBy(f, -kUp, -toCeiling, -kUp, vec3(3.0f)).x, 0.01f);
    EXPECT_GT(std::abs(full - diffuse), 0.05f);
}

// The limit takes light of two and more surfaces alone, and is not there by default.
TEST(ReferenceMaterialsS6, ClampLimitsIndirectLight)
{
    Scene scene = makeSunnyFloor({vec3(1.0f), 0.0f, 1.0f, 0.0f});
    scene.sky = {vec3(2.0f), vec3(2.0f), vec3(2.0f)};
    const float sun = 3.0f * kToSun.y / kPi;
    EXPECT_NEAR(Traced(scene).atOrigin(kView, 512).x, sun + 2.0f, 0.01f);
    EXPECT_NEAR(Traced(scene, {ReferenceSurfaces::Full, 0.5f}).atOrigin(kView, 512).x, sun + 0.5f, 0.01f);
}

Camera cameraAt(vec3 eye)
{
    Camera camera;
    camera.worldFromCamera = glm::inverse(glm::lookAt(eye, vec3(0.0f), vec3(0, 1, 0)));
    return camera;
}

TEST(ReferencePictureS6, ThreadsChangeNoBit)
{
    const Scene scene = makeSunnyFloor();
    const auto picture = [&](int threads) {
        const ThreadLimit limit(threads);
        return *renderReference(scene, cameraAt(kView), {40, 30}, {8, 2});
    };
    const ImageRgb32f one = picture(1);
    const ImageRgb32f three = picture(3);
    EXPECT_EQ(one.texels(), three.texels());
    EXPECT_GT(one(20, 15).x, 0.0f);
}

// A whole picture of so many samples takes hours; the test would not end.
TEST(ReferencePictureS6, CancelsWhileItTraces)
{
    const Scene scene = makeSunnyFloor();
    std::atomic<bool> cancel = false;
    Progress progress;
    progress.cancel = &cancel;
    double fraction = 0.0;
    progress.report = [&](std::string_view, double done) {
        fraction = std::max(fraction, done);
        if (done > 0.0) cancel = true;
    };
    std::thread later([&] {
        std::this_thread::sleep_for(std::chrono::milliseconds(300));
        cancel = true;
    });
    const auto picture = renderReference(scene, cameraAt(kView), {640, 480}, {1 << 20, 2}, progress);
    later.join();
    ASSERT_FALSE(picture);
    EXPECT_EQ(picture.error().code, ErrorCode::Cancelled);
    EXPECT_LT(fraction, 0.01);
}

} // namespace
} // namespace halflight::test::surfaces_test
