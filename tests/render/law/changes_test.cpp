// S29, S30. What may change between frames without loading anew: the picture equals that of a scene loaded so.
#include "render/render_test.h"

#include <gmock/gmock.h>

#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/packing.hpp>

#include <cmath>

namespace halflight::test::changes_test {
namespace {

class ChangesS29 : public BothPaths {
protected:
    /// A lightmapped floor, a dynamic slab over it, probes that grow brighter along x, a masked sun.
    void SetUp() override
    {
        BothPaths::SetUp();
        baked.isBaked = true;
        Scene& scene = baked.scene;
        const int material = addMaterial(scene, vec4(0.6f, 0.5f, 0.4f, 1.0f));
        addObject(scene, makeRectangle(20, 20, material), mat4(1.0f), true);
        scene.objects[0].lightmap = {0, vec2(1.0f), vec2(0.0f)};
        addObject(scene, makeRectangle(2, 2, material), glm::translate(mat4(1.0f), vec3(-4, 1, 0)), false);
        Light sun = directionalLight(vec3(0.3f, 1, 0.2f), 3.0f);
        sun.name = "sun";
        bakeAsMixed(sun, MixedLightingMode::Shadowmask, 0);
        scene.lights.push_back(sun);
        baked.lightmaps = {Image<uint32_t>(4, 4, glm::packF3x9_E1x5(vec3(0.5f)))};
        baked.shadowmasks = {ImageRgba8(4, 4, u8vec4(102, 255, 255, 255))};
        for (int i = 0; i < 8; ++i) {
            Probe probe;
            probe.position = vec3(i & 1 ? 6 : -6, i & 2 ? 4 : 0, i & 4 ? 6 : -6);
            probe.radiance[0] = vec3(i & 1 ? 4.0f : 1.0f);
            probe.occlusion.layers[0] = vec4(i & 1 ? 0.9f : 0.3f, 1, 1, 1);
            baked.probes.probes.push_back(probe);
        }
        settings.mode = RunMode::Shadowmask;
        settings.path = GetParam();
        settings.size = {192, 108};
        settings.shadows.directionalMapSize = 512;
    }
    ImageRgba32f draw(std::vector<std::string>* warnings = nullptr)
    {
        auto frame = renderer->render(camera, settings);
        if (!frame) {
            ADD_FAILURE() << frame.error().text();
            return {};
        }
        if (warnings) *warnings = frame->plan.warnings;
        return std::move(frame->radiance);
    }
    /// The picture of the scene as it is, loaded anew, must be `changed` and not `before`.
    void expectLoaded(const ImageRgba32f& changed, const ImageRgba32f& before)
    {
        ASSERT_TRUE(renderer->load(baked));
        EXPECT_EQ(draw().texels(), changed.texels());
        EXPECT_NE(before.texels(), changed.texels());
    }

    BakedScene baked;
    RenderSettings settings;
    Camera camera = lookAt(vec3(0, 6, 9), vec3(0, 0, 0));
};

INSTANTIATE_TEST_SUITE_P(, ChangesS29, kBothPaths, pathNameOf);

TEST_P(ChangesS29, LightColorAndIntensity)
{
    ASSERT_TRUE(renderer->load(baked));
    const ImageRgba32f before = draw();
    Light& light = baked.scene.lights[0];
    light.intensity = 7.0f;
    light.color = vec3(1.0f, 0.5f, 0.25f);
    light.shadowStrength = 0.7f;
    ASSERT_TRUE(renderer->setLight(0, light));
    std::vector<std::string> warnings;
    const ImageRgba32f changed = draw(&warnings);
    EXPECT_TRUE(warnings.empty());
    expectLoaded(changed, before);
}

// A light's own biases draw what the same settings draw for all lights.
TEST_P(ChangesS29, BiasesOfALight)
{
    settings.mode = RunMode::DistanceShadowmask;
    ASSERT_TRUE(renderer->load(baked));
    const ImageRgba32f before = draw();
    const ShadowSettings plain = settings.shadows;
    for (int which = 0; which < 3; ++which) {
        settings.shadows = plain;
        Light light = baked.scene.lights[0];
        if (which == 0) light.shadowBias.depthTexels = settings.shadows.depthBias = 20.0f;
        if (which == 1) light.shadowBias.slope = settings.shadows.slopeBias = 60.0f;
        if (which == 2) light.shadowBias.normalTexels = settings.shadows.normalBiasTexels = 8.0f;
        ASSERT_TRUE(renderer->setLight(0, baked.scene.lights[0]));
        const ImageRgba32f bySetting = draw();
        settings.shadows = plain;
        ASSERT_TRUE(renderer->setLight(0, light));
        EXPECT_EQ(draw().texels(), bySetting.texels()) << which;
        EXPECT_NE(before.texels(), bySetting.texels()) << which;
    }
    Light wrong = baked.scene.lights[0];
    wrong.shadowBias.normalTexels = 9.0f;
    EXPECT_FALSE(renderer->setLight(0, wrong));
    wrong.shadowBias = {NAN, {}, {}};
    EXPECT_FALSE(renderer->setLight(0, wrong));
}

TEST_P(ChangesS29, TurnedLightIsReported)
{
    ASSERT_TRUE(renderer->load(baked));
    const ImageRgba32f before = draw();
    Light light = baked.scene.lights[0];
    light.worldFromLight = lightPose(vec3(0.0f), vec3(0.6f, -1, 0.1f));
    light.baking = {}; // what the bake made of it stays, whatever is passed
    light.name = "other";
    ASSERT_TRUE(renderer->setLight(0, light));
    std::vector<std::string> warnings;
    const ImageRgba32f changed = draw(&warnings);
    EXPECT_THAT(warnings, testing::ElementsAre(testing::HasSubstr("sun")));
    baked.scene.lights[0].worldFromLight = light.worldFromLight;
    expectLoaded(changed, before);
}

// Shadow, bounds and probe light follow, also out of the view and back, and when the transform mirrors.
TEST_P(ChangesS29, MovedObject)
{
    ASSERT_TRUE(renderer->load(baked));
    const ImageRgba32f before = draw();
    ASSERT_TRUE(renderer->setObjectTransform(1, glm::translate(mat4(1.0f), vec3(0, 0, 500))));
    EXPECT_NE(draw().texels(), before.texels());
    mat4 moved = glm::translate(mat4(1.0f), vec3(4, 1.5f, 1));
    moved[0].x = -1.5f;
    ASSERT_TRUE(renderer->setObjectTransform(1, moved));
    const ImageRgba32f changed = draw();
    baked.scene.objects[1].worldFromObject = moved;
    expectLoaded(changed, before);
}

TEST_P(ChangesS29, CastAndReceiveSwitchesS30)
{
    for (int i = 0; i < 2; ++i) {
        for (const bool cast : {false, true}) {
            if (cast && i == 0) continue; // a floor that casts and receives not: nothing below it
            ASSERT_TRUE(renderer->load(baked));
            const ImageRgba32f before = draw();
            const Object was = baked.scene.objects[std::size_t(i)];
            ASSERT_TRUE(renderer->setObjectShadows(i, cast, !was.receiveShadows));
            const ImageRgba32f changed = draw();
            baked.scene.objects[std::size_t(i)].castShadows = cast;
            baked.scene.objects[std::size_t(i)].receiveShadows = !was.receiveShadows;
            expectLoaded(changed, before);
            baked.scene.objects[std::size_t(i)] = was;
        }
    }
}

TEST_P(ChangesS29, RefusesWhatCannotBe)
{
    startAnew();
    EXPECT_FALSE(renderer->setLight(0, Light{})) << "nothing loaded";
    EXPECT_TRUE(renderer->scene().objects.empty());
    ASSERT_TRUE(renderer->load(baked));
    const ImageRgba32f before = draw();
    EXPECT_FALSE(renderer->setLight(1, baked.scene.lights[0]));
    EXPECT_FALSE(renderer->setLight(-1, baked.scene.lights[0]));
    Light light = baked.scene.lights[0];
    light.intensity = -1.0f;
    EXPECT_FALSE(renderer->setLight(0, light));
    light = baked.scene.lights[0];
    light.worldFromLight[3].x = NAN;
    EXPECT_FALSE(renderer->setLight(0, light));
    EXPECT_FALSE(renderer->setObjectTransform(2, mat4(1.0f)));
    EXPECT_FALSE(renderer->setObjectTransform(0, mat4(NAN)));
    EXPECT_FALSE(renderer->setObjectShadows(-1, true, true));
    EXPECT_EQ(draw().texels(), before.texels());
}

} // namespace
} // namespace halflight::test::changes_test
