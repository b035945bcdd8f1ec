// S3, S4. Spot and point lights near, within the fade and beyond the shadow distance, with and without mask, realtime
// map and caster; several shadowed spots at once.
#include "render/law/plates.h"

namespace halflight::test::local_shadows_test {
namespace {

using namespace plates;

PlateScene localScene(LightType type)
{
    Light light;
    light.type = type;
    light.worldFromLight = lightPose(vec3(0, kHeight, 0), type == LightType::Spot ? vec3(0, -1, 0.3f) : vec3(0, -1, 0));
    light.intensity = 50.0f;
    light.rangeMeters = 20.0f;
    light.innerConeRadians = 0.7f;
    light.outerConeRadians = 0.9f;
    return PlateScene(light);
}

class LocalLawS3S4 : public RenderTest, public testing::WithParamInterface<TypePath> {};
INSTANTIATE_TEST_SUITE_P(, LocalLawS3S4,
                         testing::Combine(testing::Values(LightType::Spot, LightType::Point), kBothPaths),
                         typePathName);

TEST_P(LocalLawS3S4, NearInTheFadeAndBeyond)
{
    for (const RunMode mode :
         {RunMode::Realtime, RunMode::BakedIndirect, RunMode::Shadowmask, RunMode::DistanceShadowmask}) {
        for (const float strength : {1.0f, 0.7f}) {
            for (const float distance : {12.0f, 8.0f, 7.0f, 6.2f, 4.0f}) {
                PlateScene local = localScene(std::get<0>(GetParam()));
                Light& light = local.baked.scene.lights[0];
                light.shadowStrength = strength;
                ShadowSettings shadows;
                shadows.distanceMeters = distance;
                const RenderedFrame frame = render(local.baked, local.camera, settingsFor(mode, GetParam(), shadows));
                for (const Place& place : kPlaces) {
                    ivec2 pixel;
                    const ShadedPoint point = local.pointAt(place.point, pixel);
                    const float attenuation = local.attenuationAt(place, point.position, mode, distance);
                    vec3 expected = directRadiance(point, light, attenuation);
                    if (mode != RunMode::Realtime) expected += indirectRadiance(point, vec3(kIrradiance));
                    EXPECT_TRUE(near(vec3(frame.radiance(pixel.x, pixel.y)), expected, 2.0e-3f, law::kAbsolute))
                        << "mode " << int(mode) << " x " << point.position.x << " t "
                        << local.fadeAt(point.position, distance);
                }
            }
        }
    }
}

// Without a map (switched off, or no caster is left) B counts at every distance, also in distance shadowmask mode.
TEST_P(LocalLawS3S4, WithoutMapTheMaskAtEveryDistance)
{
    for (const RunMode mode : {RunMode::Shadowmask, RunMode::DistanceShadowmask}) {
        for (const float distance : {40.0f, 7.0f, 4.0f}) {
            for (const bool noCaster : {false, true}) {
                PlateScene local = localScene(std::get<0>(GetParam()));
                ShadowSettings shadows;
                shadows.distanceMeters = distance;
                if (noCaster)
                    for (Object& object : local.baked.scene.objects) object.castShadows = false;
                else if (std::get<0>(GetParam()) == LightType::Point)
                    shadows.pointShadows = false;
                else
                    continue;
                const RenderedFrame frame = render(local.baked, local.camera, settingsFor(mode, GetParam(), shadows));
                EXPECT_FALSE(frame.plan.lights[0].hasRealtimeShadow);
                for (const Place& place : kPlaces) {
                    ivec2 pixel;
                    const ShadedPoint point = local.pointAt(place.point, pixel);
                    const vec3 expected =
                        directRadiance(point, local.baked.scene.lights[0], point.position.x > 0.0f ? kMask : 1.0f) +
                        indirectRadiance(point, vec3(kIrradiance));
                    EXPECT_TRUE(near(vec3(frame.radiance(pixel.x, pixel.y)), expected)) << int(mode);
                }
            }
        }
    }
}

class SeveralSpotsS3 : public BothPaths {};
INSTANTIATE_TEST_SUITE_P(, SeveralSpotsS3, kBothPaths, pathNameOf);

// Six spots in a row, each over its own plate: in every plate's shadow its own light is missing and no other, so each
// light reads its own tile of the atlas, whatever their sizes.
TEST_P(SeveralSpotsS3, EachReadsItsOwnTile)
{
    constexpr int kSpots = 6;
    BakedScene baked;
    Scene& scene = baked.scene;
    const int material = addMaterial(scene, vec4(kAlbedo, 1.0f));
    addObject(scene, makeRectangle(40, 20, material), mat4(1.0f), true);
    for (int i = 0; i < kSpots; ++i) {
        const float x = 2.0f * float(i) - 5.0f;
        addObject(scene, makeRectangle(0.5f + 0.06f * float(i), 0.6f, material),
                  glm::translate(mat4(1.0f), vec3(x, 1.5f, 0)), false);
        Light light;
        light.type = LightType::Spot;
        light.worldFromLight = lightPose(vec3(x, 3.0f, 0), vec3(0, -1, 0));
        light.intensity = 20.0f + 10.0f * float(i);
        light.rangeMeters = 6.0f + float(i);
        light.innerConeRadians = 0.5f;
        light.outerConeRadians = 0.8f;
        light.mode = LightMode::Realtime;
        scene.lights.push_back(light);
    }
    for (const int atlasSize : {256, 1024, 4096}) {
        RenderSettings settings;
        settings.path = GetParam();
        settings.size = {480, 200};
        settings.shadows.atlasSize = atlasSize;
        const Camera camera = lookAt(vec3(0, 1.3f, 8), vec3(0, 0, 0), 1.0f);
        const RenderedFrame frame = render(baked, camera, settings);
        EXPECT_TRUE(frame.plan.warnings.empty());
        for (int i = 0; i < kSpots; ++i) {
            for (const float offset : {0.0f, 1.0f}) { // below the plate, and between two
                const vec3 place(2.0f * float(i) - 5.0f + offset, 0, offset == 0.0f ? 0.1f : 0.0f);
                const ivec2 pixel = pixelOf(camera, settings.size, place);
                const Ray ray = pixelRay(camera, settings.size, pixel);
                const ShadedPoint point{onPlane(ray, 0.0f), vec3(0, 1, 0), -ray.direction, kAlbedo};
                vec3 expected(0.0f);
                for (int light = 0; light < kSpots; ++light)
                    if (offset != 0.0f || light != i)
                        expected += directRadiance(point, scene.lights[std::size_t(light)], 1.0f);
                EXPECT_TRUE(near(vec3(frame.radiance(pixel.x, pixel.y)), expected, 2.0e-3f))
                    << "atlas " << atlasSize << " spot " << i << " offset " << offset;
            }
        }
    }
}

} // namespace
} // namespace halflight::test::local_shadows_test
