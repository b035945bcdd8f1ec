// Spec section 4: beyond the reach a light had at its bake B is 1, so that no light takes another's shadows. Two lights
// far apart share a channel; one of them grows until it reaches the other's mask.
#include "render/render_test.h"

#include <glm/gtc/packing.hpp>

namespace halflight::test::baked_reach_test {
namespace {

constexpr ivec2 kSize{256, 96};
constexpr float kBaked = 51.0f / 255.0f;
const vec3 kAlbedo(0.7f, 0.6f, 0.5f);

/// A floor of 24 x 6 m, all of it 51 / 255 in every channel, with lamps at x = -8 and x = 8 that share channel 2.
BakedScene floorOfTwoLamps(LightType type, bool dynamicFloor)
{
    BakedScene baked;
    baked.isBaked = true;
    Scene& scene = baked.scene;
    addObject(scene, makeRectangle(24, 6, addMaterial(scene, vec4(kAlbedo, 1.0f))), mat4(1.0f), !dynamicFloor);
    scene.objects[0].lightmap = {0, vec2(1.0f), vec2(0.0f)};
    baked.lightmaps.emplace_back(8, 8, uint32_t(0));
    baked.shadowmasks.emplace_back(8, 8, u8vec4(51));
    Probe probe;
    probe.occlusion.layers[0] = vec4(kBaked);
    baked.probes.probes = {probe};
    for (const float x : {-8.0f, 8.0f}) {
        Light light;
        light.name = x < 0 ? "left" : "right";
        light.type = type;
        light.worldFromLight = lightPose(vec3(x, 2, 0), vec3(0, -1, 0));
        light.intensity = 80.0f;
        light.rangeMeters = 6.0f;
        light.innerConeRadians = 0.4f;
        light.outerConeRadians = 0.6f;
        bakeAsMixed(light, MixedLightingMode::Shadowmask, 2);
        light.baking.reachMeters = light.rangeMeters;
        light.baking.outerConeRadians = light.outerConeRadians;
        light.baking.atBake = lightAtBake(light);
        scene.lights.push_back(light);
    }
    return baked;
}

/// B as the specification puts it, written out a second time.
float bakedByHand(const Light& light, vec3 point)
{
    const vec3 from = point - vec3(light.baking.worldFromLight[3]);
    if (glm::length(from) > 6.0f) return 1.0f;
    if (light.type == LightType::Spot && std::acos(-from.y / glm::length(from)) > 0.6f) return 1.0f;
    return kBaked;
}

class BakedReach : public RenderTest, public testing::WithParamInterface<std::tuple<LightType, bool, RenderPath>> {
protected:
    /// Pixels along the floor's middle are what the lights bring times B by hand; returns how many of the changed
    /// light's B is 1 though the mask says otherwise.
    int expectFloor(const BakedScene& baked, const RenderedFrame& frame, const Camera& camera)
    {
        int beyond = 0;
        for (int x = 4; x < kSize.x - 4; x += 3) {
            const ivec2 pixel(x, kSize.y / 2 + 3);
            const Ray ray = pixelRay(camera, kSize, pixel);
            ShadedPoint point;
            point.position = onPlane(ray, 0.0f);
            point.view = -ray.direction;
            point.baseColor = kAlbedo;
            if (std::abs(point.position.x) > 11.9f) continue;
            vec3 expected(0.0f);
            bool nearEdge = false; // of a reach: which side a pixel falls on is a matter of rounding
            for (const Light& light : baked.scene.lights) {
                const vec3 from = point.position - vec3(light.baking.worldFromLight[3]);
                nearEdge =
                    nearEdge || std::abs(glm::length(from) - 6.0f) < 0.02f ||
                    (light.type == LightType::Spot && std::abs(std::acos(-from.y / glm::length(from)) - 0.6f) < 0.005f);
                const float b = bakedByHand(light, point.position);
                const vec3 lit = directRadiance(point, light, 1.0f);
                beyond += b == 1.0f && lit.r > 1.0e-3f;
                expected += b * lit;
            }
            if (nearEdge) continue;
            EXPECT_TRUE(near(vec3(frame.radiance(pixel.x, pixel.y)), expected, 2.0e-3f, 1.0e-4f))
                << "x = " << point.position.x;
        }
        return beyond;
    }
};

TEST_P(BakedReach, BeyondItTheLightIsLit)
{
    const auto [type, dynamicFloor, path] = GetParam();
    BakedScene baked = floorOfTwoLamps(type, dynamicFloor);
    ASSERT_TRUE(renderer->load(baked));
    const Camera camera = lookAt(vec3(0, 14, 0.01f), vec3(0.0f), 0.62f);
    RenderSettings settings;
    settings.mode = RunMode::Shadowmask;
    settings.path = path;
    settings.size = kSize;
    const auto draw = [&] {
        Result<RenderedFrame> frame = renderer->render(camera, settings);
        EXPECT_TRUE(frame) << frame.error().text();
        return std::move(*frame);
    };
    const RenderedFrame before = draw();
    EXPECT_EQ(expectFloor(baked, before, camera), 0) << "nothing beyond while nothing grew";
    EXPECT_TRUE(before.plan.warnings.empty());

    Light& left = baked.scene.lights[0];
    if (type == LightType::Spot)
        left.outerConeRadians = 1.2f;
    else
        left.rangeMeters = 40.0f;
    ASSERT_TRUE(renderer->setLight(0, left));
    const RenderedFrame grown = draw();
    EXPECT_GT(expectFloor(baked, grown, camera), 5) << "the grown light must reach where the mask is another's";
    ASSERT_EQ(grown.plan.warnings.size(), 1u);
    EXPECT_NE(grown.plan.warnings[0].find("left"), std::string::npos);

    // Moved as well: the mask holds around the place of the bake.
    left.worldFromLight[3].x = 0.0f;
    ASSERT_TRUE(renderer->setLight(0, left));
    EXPECT_GT(expectFloor(baked, draw(), camera), 5);
}
INSTANTIATE_TEST_SUITE_P(S18S29, BakedReach,
                         testing::Combine(testing::Values(LightType::Point, LightType::Spot), testing::Bool(),
                                          kBothPaths));

} // namespace
} // namespace halflight::test::baked_reach_test
