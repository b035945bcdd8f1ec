// Area lights in reference pictures: closed forms, two independent estimators, and emissive surfaces in their place.
#include "bake/area_light_scene.h"
#include "reference/traced.h"

#include <gtest/gtest.h>

namespace halflight::test::area_lights_test {
namespace {

Scene stage(const Finish& finish, LightType type, bool emissive = false)
{
    Scene scene;
    addFloor(scene, addFinish(scene, finish));
    const Light light =
        areaLight(type, vec3(0.2f, 1.2f, -0.6f), vec3(0, -1, 0.4f), vec2(1.4f, 0.8f), 10.0f, LightMode::Mixed);
    if (emissive) {
        addEmissive(scene, light);
    } else {
        scene.lights.push_back(light);
    }
    return scene;
}

TEST(ReferenceAreaLights, DullFloorsHaveTheFormFactor)
{
    for (const LightType type : {LightType::Rectangle, LightType::Disk}) {
        const Finish dull{vec3(0.5f), 0.0f, 1.0f, 0.0f};
        const Traced traced(stage(dull, type));
        SCOPED_TRACE(nameOf(type));
        const double irradiance = irradianceByHand(traced.scene.lights[0], vec3(0), vec3(0, 1, 0));
        const double expected = 0.5 * irradiance / double(kPi);
        expectMean(traced.bySeeds(vec3(0.3f, 1, 0.4f), 5000), expected, {.resolved = 0.005});
    }
}

// Sampling the light and sampling the lobe are independent estimators; together they have less noise and the same mean.
TEST(ReferenceAreaLights, LightAndLobeSamplingAgree)
{
    for (const LightType type : {LightType::Rectangle, LightType::Disk}) {
        for (const float roughness : {0.2f, 0.6f}) {
            const Finish gloss{vec3(0.7f), 0.5f, roughness};
            const vec3 view(0.1f, 1.0f, 0.9f);
            const Traced both(stage(gloss, type));
            const Traced lights(stage(gloss, type), {.emitters = EmitterSampling::Surfaces});
            const Traced lobes(stage(gloss, type), {.emitters = EmitterSampling::Directions});
            SCOPED_TRACE(testing::Message() << nameOf(type) << ", roughness " << roughness);
            const SeedMean a = both.bySeeds(view, 5000);
            expectSameMean(lights.bySeeds(view, 20000), a, {.resolved = 0.015});
            expectSameMean(lobes.bySeeds(view, 20000), a, {.resolved = 0.025});
        }
    }
}

// The same light as from an emissive surface, bounces included; but a camera sees the surface alone.
TEST(ReferenceAreaLights, LightAsEmissiveSurfacesDoAndAreNotSeen)
{
    const Finish gloss{vec3(0.7f), 0.3f, 0.3f};
    const vec3 view(0.1f, 1.0f, 0.9f);
    Scene lamp = stage(gloss, LightType::Rectangle);
    Scene surface = stage(gloss, LightType::Rectangle, true);
    for (Scene* scene : {&lamp, &surface})
        addBox(*scene, vec3(-3, -0.5f, -3), vec3(3, 4, 3), addMaterial(*scene, vec3(0.6f)), true);
    const Traced a(lamp);
    const Traced b(surface);
    expectSameMean(a.bySeeds(view, 7500, 4), b.bySeeds(view, 7500, 4), {.resolved = 0.015});

    const Traced alone(stage(gloss, LightType::Rectangle));
    EXPECT_EQ(alone.radiance(vec3(0.2f, 0.5f, -0.3f), vec3(0, 0.7f, -0.3f), 16), vec3(0.0f));
    EXPECT_GT(
        Traced(stage(gloss, LightType::Rectangle, true)).radiance(vec3(0.2f, 0.5f, -0.3f), vec3(0, 0.7f, -0.3f), 16).x,
        9.0f);
}

// Shadows, their strength, and surfaces without them, by both estimators.
TEST(ReferenceAreaLights, ShadowsByStrength)
{
    for (const EmitterSampling emitters : {EmitterSampling::Both, EmitterSampling::Directions}) {
        for (const float strength : {1.0f, 0.6f, 0.0f}) {
            const Finish gloss{vec3(0.7f), 0.5f, 0.4f};
            const vec3 view(0.1f, 1.0f, 0.9f);
            Scene scene = stage(gloss, LightType::Rectangle);
            const float open = Traced(scene, {.emitters = emitters}).atOrigin(view, 60000).x;
            scene.lights[0].shadowStrength = strength;
            addRectangle(scene, {vec3(-5, 0.4f, -0.03f), vec3(10, 0, 0), vec3(0, 0, -5)},
                         addMaterial(scene, vec3(0), vec3(0), true), 1); // hides all of the light
            const float found = Traced(scene, {.emitters = emitters}).atOrigin(view, 60000).x;
            EXPECT_NEAR(found, (1.0f - strength) * open, 0.02f * open) << strength;
        }
    }
}

} // namespace
} // namespace halflight::test::area_lights_test
