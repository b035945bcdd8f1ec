#pragma once
// Scenes whose lights have coloured masks.

#include "bake/lights/colored_masks.h"
#include "bake/test_scene.h"
#include "transport/glass_scene.h"

#include <utility>
#include <vector>

namespace halflight::test::glass {

inline const vec3 kSlanted = glm::normalize(vec3(0.5f, -1.0f, 0.3f));

/// A black floor of 1 x 1 m with texels, under a white mixed sun.
inline Scene floorUnderSun()
{
    Scene scene;
    const int black = addMaterial(scene, vec3(0.0f));
    addRectangle(scene, {vec3(-0.5f, 0, 0.5f), vec3(1, 0, 0), vec3(0, 0, -1)}, black, kPage, {vec2(2), vec2(10)});
    scene.lights.push_back(makeLight(LightType::Directional, vec3(0), kSlanted, 10.0f, LightMode::Mixed));
    return scene;
}

inline IntegrationSettings oneSample()
{
    IntegrationSettings settings;
    settings.samples = 16;
    settings.bounces = 0;
    return settings;
}

/// A bench whose lights have coloured masks where their shadows have a colour.
struct ColoredBench : Bench {
    std::vector<float> shares;

    ColoredBench(Scene s, MixedLightingMode mode, const IntegratorFactory& factory = embreeIntegrators(),
                 int page = kPage)
        : Bench(std::move(s), mode, page, oneSample(), 1, factory)
    {
        shares.resize(scene.lights.size());
        EXPECT_TRUE(integrator->coloredShadows(map, shares, {}));
        colorMasks(scene, shares, 1);
        integrator = std::move(*factory.make(scene, geometry, oneSample()));
    }
};

} // namespace halflight::test::glass
