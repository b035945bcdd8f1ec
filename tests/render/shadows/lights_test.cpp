// Many lights, their order, and realtime shadows of spot and point lights.
#include "render/render_test.h"

#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>
#include <cmath>
#include <random>

namespace halflight::test::lights_test {
namespace {

constexpr ivec2 kSize{320, 180};
const vec3 kAlbedo(0.7f, 0.6f, 0.5f);

RenderSettings settingsFor(RenderPath path, ivec2 size = kSize)
{
    RenderSettings settings;
    settings.path = path;
    settings.size = size;
    settings.shadows.atlasSize = 2048;
    return settings;
}

/// 256 small point and spot lights over a floor of 40 m.
BakedScene manyLights(int count)
{
    BakedScene baked;
    Scene& scene = baked.scene;
    addObject(scene, makeRectangle(40, 60, addMaterial(scene, vec4(kAlbedo, 1.0f))),
              glm::translate(mat4(1.0f), vec3(0, 0, -25)), true);
    std::mt19937 random(7);
    auto uniform = [&](float low, float high) { return low + (high - low) * float(random() >> 8) * 0x1.0p-24f; };
    for (int i = 0; i < count; ++i) {
        Light light;
        light.type = i % 3 == 0 ? LightType::Spot : LightType::Point;
        const float x = uniform(-18, 18);
        const float y = uniform(0.5f, 2.0f);
        const float z = uniform(-50, 0);
        light.worldFromLight = lightPose(vec3(x, y, z), vec3(uniform(-0.5f, 0.5f), -1, uniform(-0.5f, 0.5f)));
        light.color = vec3(uniform(0.2f, 1), uniform(0.2f, 1), uniform(0.2f, 1));
        light.intensity = uniform(1, 10);
        light.rangeMeters = uniform(2, 6);
        light.innerConeRadians = 0.4f;
        light.outerConeRadians = 0.9f;
        light.mode = LightMode::Realtime;
        light.castShadows = false;
        light.name = "light " + std::to_string(i);
        scene.lights.push_back(light);
    }
    return baked;
}

class Lights : public BothPaths {};
INSTANTIATE_TEST_SUITE_P(, Lights, kBothPaths, pathNameOf);

// Clustered culling loses no light: the picture equals the sum over all lights of each floor point.
TEST_P(Lights, ClustersHoldAllOf256Lights)
{
    const BakedScene baked = manyLights(256);
    for (const vec3 eye : {vec3(0, 4, 3), vec3(-10, 1.2f, -8), vec3(0, 30, -20)}) {
        const Camera camera = lookAt(eye, vec3(0, 0, -21));
        const RenderedFrame frame = render(baked, camera, settingsFor(GetParam()));
        int checked = 0;
        for (int y = 3; y < kSize.y; y += 7) {
            for (int x = 2; x < kSize.x; x += 11) {
                const Ray ray = pixelRay(camera, kSize, {x, y});
                if (ray.direction.y >= -0.12f) continue; // nearer the horizon a pixel's rounding is metres of floor
                const ShadedPoint point{onPlane(ray, 0.0f), vec3(0, 1, 0), -ray.direction, kAlbedo};
                if (std::abs(point.position.x) > 19.5f || point.position.z > 4.5f || point.position.z < -54.5f)
                    continue;
                vec3 expected(0.0f);
                for (const Light& light : baked.scene.lights) expected += directRadiance(point, light, 1.0f);
                ASSERT_TRUE(near(vec3(frame.radiance(x, y)), expected, 5.0e-3f, 1.0e-4f)) << x << ' ' << y;
                ++checked;
            }
        }
        EXPECT_GT(checked, 100);
    }
}

TEST_P(Lights, PictureIndependentOfLightOrder)
{
    BakedScene baked = manyLights(40);
    for (std::size_t i = 0; i < 6; ++i) baked.scene.lights[i].castShadows = true;
    addObject(baked.scene, makeRectangle(1, 1, 0), glm::translate(mat4(1.0f), vec3(0, 0.4f, -6)), false);
    baked.scene.lights.push_back(directionalLight(vec3(1, 2, 1), 2.0f));
    baked.scene.lights.push_back(directionalLight(vec3(-1, 2, 1), 1.0f));
    const Camera camera = lookAt(vec3(0, 4, 3), vec3(0, 0, -12));
    const RenderedFrame first = render(baked, camera, settingsFor(GetParam()));
    std::mt19937 random(3);
    std::shuffle(baked.scene.lights.begin(), baked.scene.lights.end(), random);
    const RenderedFrame second = render(baked, camera, settingsFor(GetParam()));
    EXPECT_EQ(first.radiance.texels(), second.radiance.texels());
}

// S3 and point lights: umbra is dark and what lies around it is lit, for lights in any direction of the cube.
TEST_P(Lights, PointLightShadowsOnAllSixFaces)
{
    // A room of six walls around the light, and a blocker before each wall, each of another size.
    BakedScene baked;
    Scene& scene = baked.scene;
    const int material = addMaterial(scene, vec4(kAlbedo, 1.0f));
    scene.materials[std::size_t(material)].doubleSided = true;
    const vec3 axes[6] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    auto facing = [](vec3 axis, float distance) { // a rectangle at axis * distance that faces the origin
        const vec3 up = -axis;
        const vec3 side = std::abs(up.y) < 0.5f ? vec3(0, 1, 0) : vec3(1, 0, 0);
        const vec3 x = glm::normalize(glm::cross(side, up));
        return mat4(vec4(x, 0), vec4(up, 0), vec4(glm::cross(x, up), 0), vec4(axis * distance, 1));
    };
    const auto widthOf = [](int face) { return 1.2f + 0.12f * float(face); };
    for (int face = 0; face < 6; ++face) {
        addObject(scene, makeRectangle(8, 8, material), facing(axes[face], 4.0f), true);
        addObject(scene, makeRectangle(widthOf(face), widthOf(face), material), facing(axes[face], 2.0f), false);
    }
    Light light;
    light.type = LightType::Point;
    light.intensity = 30.0f;
    light.mode = LightMode::Realtime;
    scene.lights.push_back(light);

    for (const ShadowFilter filter : {ShadowFilter::Hard, ShadowFilter::Pcf, ShadowFilter::Soft}) {
        for (int face = 0; face < 6; ++face) {
            const vec3 axis = axes[face];
            const float edge = widthOf(face); // of the shadow on the wall, twice as far away: half its width
            // From beside the light, past the blocker, at the wall.
            const vec3 side = facing(axis, 1.0f)[0];
            const Camera camera = lookAt(axis * 1.0f + side * 2.0f, axis * 4.0f, 2.2f);
            RenderSettings settings = settingsFor(GetParam(), {160, 90});
            settings.shadows.filter = filter;
            const RenderedFrame frame = render(baked, camera, settings);
            const vec3 other = glm::cross(axis, side);
            for (const vec2 offset : {vec2(0.3f, 0.2f), vec2(-0.2f, -0.3f), vec2(edge - 0.9f, 0.2f),
                                      vec2(edge + 0.9f, 0.2f), vec2(0.1f, edge + 0.75f), vec2(2.8f, -2.2f)}) {
                const ivec2 pixel = pixelOf(camera, {160, 90}, axis * 4.0f + side * offset.x + other * offset.y);
                ASSERT_TRUE(pixel.x >= 0 && pixel.y >= 0 && pixel.x < 160 && pixel.y < 90);
                const Ray ray = pixelRay(camera, {160, 90}, pixel);
                const float reach = (4.0f - glm::dot(ray.origin, axis)) / glm::dot(ray.direction, axis);
                const vec3 position = ray.origin + ray.direction * reach;
                const ShadedPoint point{position, -axis, -ray.direction, kAlbedo};
                const bool shadowed = std::abs(offset.x) < edge && std::abs(offset.y) < edge;
                EXPECT_TRUE(
                    near(vec3(frame.radiance(pixel.x, pixel.y)), directRadiance(point, light, shadowed ? 0.0f : 1.0f)))
                    << "axis " << axis.x << axis.y << axis.z << " offset " << offset.x << ' ' << offset.y;
            }
        }
    }
}

// S1. Beyond the shadow distance no realtime shadow is left.
TEST_P(Lights, SpotShadowEndsAtShadowDistanceS1)
{
    BakedScene baked;
    Scene& scene = baked.scene;
    const int material = addMaterial(scene, vec4(kAlbedo, 1.0f));
    addObject(scene, makeRectangle(20, 20, material), mat4(1.0f), true);
    addObject(scene, makeRectangle(2, 2, material), glm::translate(mat4(1.0f), vec3(0, 2, 0)), false);
    Light light;
    light.type = LightType::Spot;
    light.intensity = 100.0f;
    light.worldFromLight = lightPose(vec3(0, 5, 0), vec3(0, -1, 0));
    light.mode = LightMode::Realtime;
    scene.lights.push_back(light);
    const vec3 eye(0, 1.5f, 9);
    const Camera camera = lookAt(eye, vec3(0, 0, 0));
    const ivec2 pixel = pixelOf(camera, kSize, vec3(0.2f, 0, 0.3f));
    const Ray ray = pixelRay(camera, kSize, pixel);
    const ShadedPoint point{onPlane(ray, 0.0f), vec3(0, 1, 0), -ray.direction, kAlbedo};
    const float distance = glm::distance(eye, point.position);
    for (const float t : {0.0f, 0.3f, 0.75f, 1.0f}) {
        RenderSettings settings = settingsFor(GetParam());
        settings.shadows.fadeRangeMeters = 2.0f;
        settings.shadows.distanceMeters = distance + 2.0f * (1.0f - t);
        if (t == 1.0f) settings.shadows.distanceMeters = distance - 0.1f;
        if (t == 0.0f) settings.shadows.distanceMeters = distance + 2.5f;
        const RenderedFrame frame = render(baked, camera, settings);
        EXPECT_TRUE(near(vec3(frame.radiance(pixel.x, pixel.y)), directRadiance(point, light, t), 2.0e-3f)) << t;
    }
}

} // namespace
} // namespace halflight::test::lights_test
