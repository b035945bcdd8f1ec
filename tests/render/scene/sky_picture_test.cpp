// The sky's picture: behind the scene, in mirrors, and as the ambient of realtime mode (spec S10).
#include "bake/test_sky.h"
#include "render/render_test.h"

#include "halflight/shading/brdf.h"

#include <cmath>

namespace halflight::test::sky_picture_test {
namespace {

constexpr ivec2 kSize{160, 90};

RenderSettings settingsFor(RenderPath path)
{
    RenderSettings settings;
    settings.path = path;
    settings.size = kSize;
    return settings;
}

vec3 smooth(vec3 d)
{
    return vec3(2.0f) + d;
}

class SkyPictures : public BothPaths {};
INSTANTIATE_TEST_SUITE_P(, SkyPictures, kBothPaths, pathNameOf);

TEST_P(SkyPictures, FillTheBackgroundByDirection)
{
    BakedScene baked;
    for (const float rotation : {0.0f, 0.5f * kPi, -2.0f}) {
        baked.scene.sky = skyOf(skyPicture(512, smooth), rotation);
        const Camera camera = lookAt(vec3(0.0f), vec3(0.3f, 0.6f, -1));
        const RenderedFrame frame = render(baked, camera, settingsFor(GetParam()));
        for (const ivec2 p : {ivec2(0, 0), ivec2(159, 89), ivec2(80, 45), ivec2(10, 80)}) {
            const vec3 d = pixelRay(camera, kSize, p).direction;
            const float c = std::cos(rotation);
            const float s = std::sin(rotation);
            const vec3 turnedBack(c * d.x - s * d.z, d.y, s * d.x + c * d.z);
            EXPECT_TRUE(near(vec3(frame.radiance(p.x, p.y)), smooth(turnedBack), 6e-3f)) << rotation;
        }
    }
}

// Four colours by quarter of a turn, each where the format's document says: +X is the middle.
TEST_P(SkyPictures, HaveTheDocumentedDirections)
{
    const vec3 colors[4] = {vec3(1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1), vec3(1, 1, 0)};
    ImageRgb32f picture(64, 32);
    for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 64; ++x) picture(x, y) = 1.0e5f * colors[((x + 8) / 16) % 4];
    BakedScene baked;
    baked.scene.sky = skyOf(std::move(picture));
    const vec3 directions[4] = {vec3(-1, 0, 0), vec3(0, 0, -1), vec3(1, 0, 0), vec3(0, 0, 1)};
    for (int i = 0; i < 4; ++i) {
        const RenderedFrame frame = render(baked, lookAt(vec3(0.0f), directions[i], 0.2f), settingsFor(GetParam()));
        EXPECT_TRUE(near(vec3(frame.radiance(80, 45)), 1.0e5f * colors[i], 4e-3f)) << i;
    }
}

// A floor from above in realtime mode.
struct Floor {
    BakedScene baked;
    Camera camera = lookAt(vec3(0.5f, 1, 0.8f), vec3(0));
    ShadedPoint point;

    Floor()
    {
        addObject(baked.scene, makeRectangle(4, 4, addMaterial(baked.scene, vec4(0.5f, 0.6f, 0.7f, 1.0f))), mat4(1.0f),
                  true);
        const Ray ray = pixelRay(camera, kSize, kSize / 2);
        point = {onPlane(ray, 0.0f), vec3(0, 1, 0), -ray.direction, vec3(0.5f, 0.6f, 0.7f)};
    }
};

// Under 2 + y a surface that faces up receives 2 pi + 2 pi / 3.
TEST_P(SkyPictures, LightRealtimeModeByTheirIrradiance)
{
    Floor floor;
    floor.baked.scene.sky = skyOf(skyPicture(512, [](vec3 d) { return vec3(2.0f + d.y); }));
    const RenderedFrame frame = render(floor.baked, floor.camera, settingsFor(GetParam()));
    EXPECT_TRUE(
        near(vec3(frame.radiance(80, 45)), indirectRadiance(floor.point, vec3(kPi * (2.0f + 2.0f / 3.0f))), 4e-3f));
}

TEST_P(SkyPictures, ShowInMirrors)
{
    Floor floor;
    floor.baked.scene.sky = skyOf(skyPicture(512, smooth), 1.0f);
    Material& material = floor.baked.scene.materials[0];
    material.metallic = 1.0f;
    material.roughness = 0.0f;
    const RenderedFrame frame = render(floor.baked, floor.camera, settingsFor(GetParam()));
    const vec3 d = glm::reflect(-floor.point.view, vec3(0, 1, 0));
    const vec3 turnedBack(std::cos(1.0f) * d.x - std::sin(1.0f) * d.z, d.y,
                          std::sin(1.0f) * d.x + std::cos(1.0f) * d.z);
    const vec3 share = shading::environmentSpecular(floor.point.baseColor, 1.0f, 0.0f, floor.point.view.y);
    EXPECT_TRUE(near(vec3(frame.radiance(80, 45)), share * smooth(turnedBack), 8e-3f));
}

// The level of a lobe has texels of its solid angle, and rough surfaces do not show a sun's texels.
TEST(SkyPictureLevel, TexelsHaveTheLobesSolidAngle)
{
    for (const float roughness : {0.3f, 0.5f, 0.8f}) {
        const float alpha = roughness * roughness;
        const float texel =
            8.0f * kPi / (1024.0f * 1024.0f) * std::exp2(2.0f * shading::skyPictureLevel(roughness, 1024.0f));
        EXPECT_NEAR(texel, 4.0f * kPi * alpha * alpha, 1e-3f * texel);
    }
    EXPECT_EQ(shading::skyPictureLevel(0.0f, 1024.0f), 0.0f);
    EXPECT_EQ(shading::skyPictureLevel(0.01f, 64.0f), 0.0f);
}

// uv and direction are each other's inverse, whatever the turn.
TEST(SkyPictureUv, IsTheInverseOfDirection)
{
    for (const float angle : {0.0f, 0.9f, -2.5f}) {
        const vec2 turn(std::cos(angle), std::sin(angle));
        for (float v = 0.05f; v < 1.0f; v += 0.1f)
            for (float u = 0.03f; u < 1.0f; u += 0.1f) {
                const vec3 d = shading::skyPictureDirection(vec2(u, v), turn);
                EXPECT_NEAR(glm::length(d), 1.0f, 1e-6f);
                EXPECT_LT(glm::distance(shading::skyPictureUv(d, turn), vec2(u, v)), 1e-6f);
            }
    }
    EXPECT_EQ(shading::skyPictureUv(vec3(0, 1, 0), vec2(1, 0)), vec2(0.5f, 0.0f));
    EXPECT_LT(glm::distance(shading::skyPictureUv(vec3(0, 0, 1), vec2(1, 0)), vec2(0.75f, 0.5f)), 1e-6f);
}

} // namespace
} // namespace halflight::test::sky_picture_test
