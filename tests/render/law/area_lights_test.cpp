// Area lights as pixels: closed forms of their form factors, and the law in all modes, forward and deferred (spec S3,
// S12, S13, S20).
#include "render/law/plates.h"

#include <cmath>

namespace halflight::test::area_lights_test {
namespace {

using namespace plates;

Light areaLight(LightType type, vec3 direction)
{
    Light light;
    light.type = type;
    light.sizeMeters = vec2(1.5f, 1.0f);
    light.worldFromLight = lightPose(vec3(0, kHeight, 0), direction);
    light.intensity = 30.0f;
    return light;
}

/// Irradiance by brute force: the light in small pieces.
double irradianceByHand(const Light& light, vec3 point, vec3 normal)
{
    constexpr int kSide = 120;
    const float height = light.type == LightType::Disk ? light.sizeMeters.x : light.sizeMeters.y;
    double sum = 0.0;
    for (int i = 0; i < kSide * kSide; ++i) {
        const vec2 at = (vec2(i % kSide, i / kSide) + 0.5f) / float(kSide) - 0.5f;
        if (light.type == LightType::Disk && glm::length(at) > 0.5f) continue;
        const vec3 way = light.position() + at.x * light.sizeMeters.x * vec3(light.worldFromLight[0]) +
                         at.y * height * vec3(light.worldFromLight[1]) - point;
        const float d2 = glm::dot(way, way);
        const float cosines = std::max(glm::dot(way, normal), 0.0f) * std::max(-glm::dot(way, light.direction()), 0.0f);
        sum += double(cosines / (d2 * d2));
    }
    return sum * double(light.intensity * light.sizeMeters.x * height) / (kSide * kSide);
}

/// Above plates and floor that are purely diffuse.
PlateScene areaScene(LightType type)
{
    PlateScene area(areaLight(type, vec3(0.1f, -1, 0.2f)));
    area.baked.scene.materials[0].specular = 0.0f;
    return area;
}

class AreaLawS3 : public RenderTest, public testing::WithParamInterface<TypePath> {};
INSTANTIATE_TEST_SUITE_P(, AreaLawS3,
                         testing::Combine(testing::Values(LightType::Rectangle, LightType::Disk), kBothPaths),
                         typePathName);

// Without penumbrae realtime shadows are those of a light at its middle; the mask and the mode mix with them as for any
// light.
TEST_P(AreaLawS3, EveryModeNearInTheFadeAndBeyond)
{
    for (const RunMode mode :
         {RunMode::Realtime, RunMode::BakedIndirect, RunMode::Shadowmask, RunMode::DistanceShadowmask}) {
        for (const float strength : {1.0f, 0.7f}) {
            for (const float distance : {12.0f, 7.0f, 4.0f}) {
                PlateScene area = areaScene(std::get<0>(GetParam()));
                Light& light = area.baked.scene.lights[0];
                light.shadowStrength = strength;
                ShadowSettings shadows;
                shadows.distanceMeters = distance;
                shadows.penumbrae = false; // PenumbraeS2 tests these
                const RenderedFrame frame = render(area.baked, area.camera, settingsFor(mode, GetParam(), shadows));
                for (const Place& place : kPlaces) {
                    ivec2 pixel;
                    const vec3 point = area.pointAt(place.point, pixel).position;
                    const float attenuation = area.attenuationAt(place, point, mode, distance);
                    double irradiance = double(attenuation) * irradianceByHand(light, point, vec3(0, 1, 0));
                    if (mode != RunMode::Realtime) irradiance += double(kIrradiance);
                    const vec3 expected = kAlbedo * float(irradiance / double(kPi));
                    EXPECT_TRUE(near(vec3(frame.radiance(pixel.x, pixel.y)), expected, 4.0e-3f, law::kAbsolute))
                        << "mode " << int(mode) << " x " << point.x << " t " << area.fadeAt(point, distance);
                }
            }
        }
    }
}

class AreaSubtractiveS22 : public RenderTest, public testing::WithParamInterface<TypePath> {};
INSTANTIATE_TEST_SUITE_P(, AreaSubtractiveS22,
                         testing::Combine(testing::Values(LightType::Rectangle, LightType::Disk), kBothPaths),
                         typePathName);

// Area lights are never the main light: static receivers have all of their light in the lightmap, dynamic shadows or
// not; dynamic receivers have it at run time, with the shadows of dynamic casters alone.
TEST_P(AreaSubtractiveS22, LightmapOnStaticAndRealtimeOnDynamicReceivers)
{
    PlateScene area = areaScene(std::get<0>(GetParam()));
    Scene& scene = area.baked.scene;
    area.baked.mode = MixedLightingMode::Subtractive;
    area.baked.shadowmasks.clear();
    Light& light = scene.lights[0];
    bakeAsMixed(light, MixedLightingMode::Subtractive, -1);
    // The static plate beside the dynamic one, and a dynamic receiver that both would shade, 20 cm above the floor's
    // left.
    scene.objects[2].worldFromObject = glm::translate(mat4(1.0f), vec3(-2, 1, 2));
    addObject(scene, makeRectangle(4, 3, 0), glm::translate(mat4(1.0f), vec3(-2, 0.2f, 4.5f)), false);
    scene.objects[3].castShadows = false;
    for (const float strength : {1.0f, 0.7f}) {
        light.shadowStrength = strength;
        ShadowSettings shadows;
        shadows.distanceMeters = 40.0f;
        const RenderedFrame frame =
            render(area.baked, area.camera, settingsFor(RunMode::Subtractive, GetParam(), shadows));
        const auto check = [&](vec3 place, bool dynamicReceiver, float attenuation) {
            const ivec2 pixel = pixelOf(area.camera, kSize, place);
            const vec3 point = onPlane(pixelRay(area.camera, kSize, pixel), place.y);
            const double irradiance =
                dynamicReceiver ? double(attenuation) * irradianceByHand(light, point, vec3(0, 1, 0)) : 0.25;
            EXPECT_TRUE(near(vec3(frame.radiance(pixel.x, pixel.y)), kAlbedo * float(irradiance / double(kPi)), 4.0e-3f,
                             law::kAbsolute))
                << "x " << point.x << " strength " << strength;
        };
        check(vec3(0.8f, 0, 3.6f), false, 1.0f); // in the dynamic plate's shadow
        check(vec3(0.9f, 0, 4.5f), false, 1.0f); // lit
        check(vec3(-0.8f, 0.2f, 3.4f), true, 1.0f - strength);
        check(vec3(-2.5f, 0.2f, 3.4f), true, 1.0f); // in the static plate's shadow
        check(vec3(-3.0f, 0.2f, 5.0f), true, 1.0f);
    }
}

class AreaLightPixels : public BothPaths {};
INSTANTIATE_TEST_SUITE_P(, AreaLightPixels, kBothPaths, pathNameOf);

/// A diffuse floor, a light above it that shines down, without shadows.
BakedScene floorBelow(LightType type)
{
    BakedScene plain;
    const int material = addMaterial(plain.scene, vec4(kAlbedo, 1.0f));
    plain.scene.materials[0].specular = 0.0f;
    addObject(plain.scene, makeRectangle(20, 20, material), mat4(1.0f), true);
    plain.scene.lights.push_back(areaLight(type, vec3(0, -1, 0)));
    plain.scene.lights[0].castShadows = false;
    return plain;
}

/// Form factors of a disk and a rectangle over a parallel plane at distance h: Howell's catalog, B-13 and B-1 (four
/// corners, each with the sign of its quarter).
double diskFactor(double radius, double h, double r)
{
    const double sum = h * h + r * r + radius * radius;
    const double root = std::sqrt(sum * sum - 4.0 * r * r * radius * radius);
    return 0.5 * (1.0 - (sum - 2.0 * radius * radius) / root);
}
double cornerFactor(double a, double b, double h)
{
    const double x = a / h;
    const double y = b / h;
    return (x / std::sqrt(1 + x * x) * std::atan(y / std::sqrt(1 + x * x)) +
            y / std::sqrt(1 + y * y) * std::atan(x / std::sqrt(1 + y * y))) /
           (2.0 * double(kPi));
}
double rectangleFactor(const Light& light, vec3 point)
{
    const auto x = double(glm::dot(point - light.position(), vec3(light.worldFromLight[0])));
    const auto y = double(glm::dot(point - light.position(), vec3(light.worldFromLight[1])));
    const double a = 0.5 * double(light.sizeMeters.x);
    const double b = 0.5 * double(light.sizeMeters.y);
    double sum = 0.0;
    for (const double sx : {-1.0, 1.0})
        for (const double sy : {-1.0, 1.0}) sum += sx * sy * cornerFactor(sx * a - x, sy * b - y, double(kHeight));
    return sum;
}

TEST_P(AreaLightPixels, FormFactorsOfRectangleAndDisk)
{
    for (const LightType type : {LightType::Rectangle, LightType::Disk}) {
        const BakedScene plain = floorBelow(type);
        const Light& light = plain.scene.lights[0];
        RenderSettings settings;
        settings.mode = RunMode::Realtime;
        settings.path = GetParam();
        settings.size = kSize;
        const Camera camera = lookAt(vec3(0, 6, 9), vec3(0, 0, 0), kPi / 3.0f);
        const RenderedFrame frame = render(plain, camera, settings);
        int checked = 0;
        for (int y = 2; y < kSize.y; y += 9) {
            for (int x = 3; x < kSize.x; x += 13) {
                const Ray ray = pixelRay(camera, kSize, {x, y});
                if (ray.direction.y > -0.2f) continue;
                const vec3 point = onPlane(ray, 0.0f);
                if (std::max(std::abs(point.x), std::abs(point.z)) > 9.5f) continue;
                const double factor = type == LightType::Disk ? diskFactor(0.75, double(kHeight),
                                                                           double(glm::length(vec2(point.x, point.z))))
                                                              : rectangleFactor(light, point);
                const vec3 expected = kAlbedo * float(factor * 30.0); // pi of the irradiance and of the albedo cancel
                ASSERT_TRUE(near(vec3(frame.radiance(x, y)), expected, 2.0e-3f))
                    << nameOf(type) << ' ' << x << ' ' << y;
                ++checked;
            }
        }
        EXPECT_GT(checked, 100);
    }
}

// A light with a range ends there, and one that faces away gives nothing.
TEST_P(AreaLightPixels, RangeAndBack)
{
    BakedScene plain = floorBelow(LightType::Rectangle);
    plain.scene.lights[0].rangeMeters = 6.0f;
    plain.scene.lights.push_back(areaLight(LightType::Disk, vec3(0, 1, 0)));
    RenderSettings settings;
    settings.mode = RunMode::Realtime;
    settings.path = GetParam();
    settings.size = kSize;
    const Camera camera = lookAt(vec3(0, 6, 12), vec3(0, 0, 0), kPi / 3.0f);
    const RenderedFrame frame = render(plain, camera, settings);
    for (const float z : {0.0f, 2.0f, 4.0f, 4.6f}) {
        const ivec2 pixel = pixelOf(camera, kSize, vec3(0.3f, 0, z));
        const vec3 point = onPlane(pixelRay(camera, kSize, pixel), 0.0f);
        const float ratio = glm::distance(point, vec3(0, kHeight, 0)) / 6.0f;
        const float window = std::max(1.0f - ratio * ratio * ratio * ratio, 0.0f);
        const vec3 expected = kAlbedo * float(rectangleFactor(plain.scene.lights[0], point) * 30.0) * window;
        EXPECT_TRUE(near(vec3(frame.radiance(pixel.x, pixel.y)), expected, 3.0e-3f)) << z;
    }
}

} // namespace
} // namespace halflight::test::area_lights_test
