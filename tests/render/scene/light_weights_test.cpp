// S33. Weights of light groups: what sets them, what follows, what a frame does for it, and what is refused.
#include "render/scene/light_groups_scene.h"

#include <gmock/gmock.h>

#include <array>
#include <cmath>

namespace halflight::test::light_weights_test {
namespace {

using testing::HasSubstr;

class LightWeightsS33 : public RenderTest {
protected:
    void SetUp() override
    {
        RenderTest::SetUp();
        settings.mode = RunMode::Shadowmask;
        settings.size = {96, 54};
        settings.shadows.directionalMapSize = 256;
    }
    RenderedFrame draw() { return render(camera, settings); }
    vec3 weightOf(const std::string& name)
    {
        for (const GroupWeight& group : renderer->lightGroups())
            if (group.name == name) return group.weight;
        ADD_FAILURE() << name;
        return vec3(-1.0f);
    }
    /// Colour times intensity of a light as it is drawn.
    vec3 lightOf(int index)
    {
        const Light& light = renderer->scene().lights[std::size_t(index)];
        return light.color * light.intensity;
    }
    void setColorIntensity(int index, vec3 color, float intensity)
    {
        Light light = renderer->scene().lights[std::size_t(index)];
        light.color = color;
        light.intensity = intensity;
        ASSERT_TRUE(renderer->setLight(index, light));
    }

    RenderSettings settings;
    Camera camera = lookAt(vec3(0, 5, 7), vec3(0, 0.3f, 0));
};

TEST_F(LightWeightsS33, AreComposedOnceForEachChange)
{
    const BakedScene baked = groupedScene(true);
    ASSERT_TRUE(renderer->load(baked));
    EXPECT_EQ(composePassesOf(draw()), 1) << "of the saved weights";
    EXPECT_EQ(composePassesOf(draw()), 0);
    for (const float weight : {0.3f, 0.6f, 0.9f}) ASSERT_TRUE(renderer->setLightGroup("lamp", vec3(weight)));
    ASSERT_TRUE(renderer->setLightGroup("sun", vec3(2.0f)));
    EXPECT_EQ(composePassesOf(draw()), 1);
    for (int i = 0; i < 3; ++i) EXPECT_EQ(composePassesOf(draw()), 0);
    ASSERT_TRUE(renderer->setLightGroup("sun", vec3(2.0f)));
    EXPECT_EQ(composePassesOf(draw()), 0) << "the weight that it has";
    ASSERT_TRUE(renderer->setObjectTransform(2, glm::translate(mat4(1.0f), vec3(1, 1, 1))));
    EXPECT_EQ(composePassesOf(draw()), 0);
    ASSERT_TRUE(renderer->load(stateOf(baked, {})));
    EXPECT_EQ(composePassesOf(draw()), 0) << "no groups";
    EXPECT_TRUE(renderer->lightGroups().empty());
}

TEST_F(LightWeightsS33, SetTheLightOfMembers)
{
    ASSERT_TRUE(renderer->load(groupedScene()));
    ASSERT_EQ(renderer->lightGroups().size(), 4u);
    EXPECT_EQ(weightOf("lamp"), vec3(1.0f, 0.5f, 0.25f));
    ASSERT_TRUE(renderer->setLightGroup("lamp", vec3(2.0f, 1.0f, 0.0f)));
    EXPECT_EQ(weightOf("lamp"), vec3(2.0f, 1.0f, 0.0f));
    EXPECT_EQ(lightOf(0), vec3(40.0f, 20.0f, 0.0f));
    ASSERT_TRUE(renderer->setLightGroup("neon", vec3(0.5f, 0.0f, 1.0f)));
    EXPECT_EQ(lightOf(2), vec3(2.5f, 0.0f, 5.0f));
    EXPECT_EQ(renderer->scene().materials[1].emissiveNits, vec3(1.5f, 0.0f, 1.0f));
    EXPECT_EQ(renderer->scene().materials[0].emissiveNits, vec3(0.0f));
    ASSERT_TRUE(renderer->setLightGroup("day", vec3(2.0f)));
    EXPECT_EQ(renderer->scene().sky.zenith, vec3(0.4f, 0.6f, 1.0f));
    EXPECT_TRUE(draw().plan.warnings.empty()) << "bounced light follows, and so does that of a baked lamp";
}

// A lamp that is off keeps its intensity; saved weights bring back colour and intensity to the bit.
TEST_F(LightWeightsS33, OffAndBackIsAsItWas)
{
    const BakedScene baked = groupedScene();
    ASSERT_TRUE(renderer->load(baked));
    const ImageRgba32f before = draw().radiance;
    for (const GroupWeight& off : kAllGroupsOff) ASSERT_TRUE(renderer->setLightGroup(off.name, off.weight));
    EXPECT_EQ(renderer->scene().lights[0].color, vec3(0.0f));
    EXPECT_EQ(renderer->scene().lights[0].intensity, baked.scene.lights[0].intensity);
    EXPECT_NE(draw().radiance.texels(), before.texels());
    for (const BakedGroup& group : baked.groups) ASSERT_TRUE(renderer->setLightGroup(group.name, group.weight));
    for (std::size_t i = 0; i < baked.scene.lights.size(); ++i) {
        EXPECT_EQ(renderer->scene().lights[i].color, baked.scene.lights[i].color);
        EXPECT_EQ(renderer->scene().lights[i].intensity, baked.scene.lights[i].intensity);
    }
    EXPECT_EQ(draw().radiance.texels(), before.texels());
}

TEST_F(LightWeightsS33, FollowALightThatIsAloneInItsGroup)
{
    const BakedScene baked = groupedScene();
    ASSERT_TRUE(renderer->load(baked));
    draw();
    setColorIntensity(1, vec3(1.0f, 0.5f, 0.0f), 12.0f);
    EXPECT_EQ(weightOf("sun"), vec3(2.0f, 1.0f, 0.0f));
    EXPECT_EQ(lightOf(1), vec3(12.0f, 6.0f, 0.0f));
    const RenderedFrame byLight = draw();
    EXPECT_EQ(composePassesOf(byLight), 1);
    EXPECT_TRUE(byLight.plan.warnings.empty());
    ASSERT_TRUE(renderer->load(baked));
    ASSERT_TRUE(renderer->setLightGroup("sun", vec3(2.0f, 1.0f, 0.0f)));
    EXPECT_EQ(compare(draw().radiance, byLight.radiance).differing, 0);
    // A baked lamp takes its plate along.
    setColorIntensity(2, vec3(0.2f, 0.4f, 0.6f), 5.0f);
    EXPECT_TRUE(near(renderer->scene().materials[1].emissiveNits, vec3(0.6f, 0.8f, 0.6f)));
    // What is no colour or intensity changes no weight, and composes nothing.
    draw();
    Light weaker = renderer->scene().lights[1];
    weaker.shadowStrength = 0.5f;
    ASSERT_TRUE(renderer->setLight(1, weaker));
    EXPECT_EQ(composePassesOf(draw()), 0);
}

// Two lights of one group: the first one's change is direct light alone, with the warning of today; when the second one
// has the same factor, all of the group has it.
TEST_F(LightWeightsS33, FollowLightsThatAgree)
{
    BakedScene baked = groupedScene();
    Light& second = baked.scene.lights[2]; // 5 cd in white beside 20 cd, and mixed
    second.baking.group = kLamp;
    second.baking.bakeType = LightMode::Mixed;
    second.color = baked.groups[kLamp].weight;
    second.baking.atBake = lightAtBake(second);
    ASSERT_TRUE(renderer->load(baked));
    draw();
    const vec3 saved = baked.groups[kLamp].weight;
    setColorIntensity(0, saved, 1.25f); // a sixteenth
    EXPECT_EQ(weightOf("lamp"), saved);
    RenderedFrame frame = draw();
    EXPECT_EQ(composePassesOf(frame), 0);
    EXPECT_THAT(frame.plan.warnings, testing::Contains(HasSubstr("ceiling lamp")));
    setColorIntensity(2, saved, 0.3125f);
    EXPECT_TRUE(near(weightOf("lamp"), 0.0625f * saved));
    frame = draw();
    EXPECT_EQ(composePassesOf(frame), 1);
    EXPECT_TRUE(frame.plan.warnings.empty());
    // One of them apart again, and then the group's weight: all are of it.
    setColorIntensity(0, vec3(1.0f), 100.0f);
    EXPECT_TRUE(near(weightOf("lamp"), 0.0625f * saved));
    ASSERT_TRUE(renderer->setLightGroup("lamp", vec3(0.5f)));
    EXPECT_TRUE(near(lightOf(0), vec3(10.0f)));
    EXPECT_TRUE(near(lightOf(2), vec3(2.5f)));
    setColorIntensity(0, vec3(1.0f), 100.0f);
    ASSERT_TRUE(renderer->setLightGroup("lamp", vec3(0.5f)));
    EXPECT_TRUE(near(lightOf(0), vec3(10.0f))) << "the weight that it had";
}

TEST_F(LightWeightsS33, ReflectionProbesAreNamedWhereTheyAreOld)
{
    BakedScene baked = groupedScene();
    baked.reflections.probes.emplace_back().fadeMeters = 1.0f;
    baked.reflections.size = 8;
    baked.reflections.picture = Image<uint32_t>(8, 12);
    ASSERT_TRUE(renderer->load(baked));
    EXPECT_TRUE(draw().plan.warnings.empty());
    ASSERT_TRUE(renderer->setLightGroup("day", vec3(0.5f)));
    EXPECT_THAT(draw().plan.warnings, testing::ElementsAre(HasSubstr("less than 1 % of what reflection probes show")));
    settings.reflectionProbes = false;
    EXPECT_TRUE(draw().plan.warnings.empty());
}

TEST_F(LightWeightsS33, UpdatedRectanglesAreTheRests)
{
    BakedScene baked = groupedScene();
    ASSERT_TRUE(renderer->load(baked));
    ASSERT_TRUE(renderer->setLightGroup("lamp", vec3(2.0f)));
    draw();
    const Image<uint32_t> texels(5, 7, packRgb9e5(vec3(60000.0f, 1.0f, 5.0f))); // brighter than all before
    const std::array<LightmapRectangle, 1> rectangles{{{1, {4, 6}, &texels}}};
    ASSERT_TRUE(renderer->updateLightmaps(rectangles));
    const RenderedFrame updated = draw();
    EXPECT_EQ(composePassesOf(updated), 1);
    for (int y = 0; y < 7; ++y)
        for (int x = 0; x < 5; ++x) baked.lightmaps[1](4 + x, 6 + y) = texels(x, y);
    const RenderedFrame loaded = render(stateOf(baked, {{"lamp", vec3(2.0f)}}), camera, settings);
    EXPECT_EQ(compare(loaded.radiance, updated.radiance).differing, 0);
}

TEST_F(LightWeightsS33, RefuseWhatCannotBe)
{
    startAnew();
    EXPECT_FALSE(renderer->setLightGroup("lamp", vec3(1.0f))) << "nothing is loaded";
    ASSERT_TRUE(renderer->load(groupedScene()));
    const ImageRgba32f before = draw().radiance;
    const Status unknown = renderer->setLightGroup("lamps", vec3(1.0f));
    ASSERT_FALSE(unknown);
    EXPECT_EQ(unknown.error().code, ErrorCode::InvalidArgument);
    EXPECT_EQ(unknown.error().message, "has no light group \"lamps\"; its groups are lamp, sun, day, neon");
    for (const vec3 bad : {vec3(-1.0f), vec3(1.0f, NAN, 1.0f), vec3(kInfinity), vec3(1.0f, 1.0f, 2.0e12f)})
        EXPECT_FALSE(renderer->setLightGroup("lamp", bad));
    EXPECT_EQ(draw().radiance.texels(), before.texels());
    ASSERT_TRUE(renderer->load(stateOf(groupedScene(), {})));
    EXPECT_EQ(renderer->setLightGroup("lamp", vec3(1.0f)).error().message,
              "has no light group \"lamp\", nor any other");
}

TEST_F(LightWeightsS33, ScenesWhoseGroupsDoNotFitAreRefused)
{
    const auto refusal = [&](auto change) {
        BakedScene baked = groupedScene(true);
        change(baked);
        const Status status = renderer->load(baked);
        return status ? std::string("loaded") : status.error().text();
    };
    EXPECT_THAT(refusal([](BakedScene& b) { b.groups[0].lightmaps.pop_back(); }), HasSubstr("lamp"));
    EXPECT_THAT(refusal([](BakedScene& b) { b.groups[0].lightmaps[1] = Image<uint32_t>(8, 16); }), HasSubstr("size"));
    EXPECT_THAT(refusal([](BakedScene& b) { b.groups[0].directions[1] = ImageRgba8(16, 8); }), HasSubstr("size"));
    EXPECT_THAT(refusal([](BakedScene& b) { b.groups[0].directions.pop_back(); }), HasSubstr("direction pages"));
    EXPECT_THAT(refusal([](BakedScene& b) { b.groups[1].weight.y = NAN; }), HasSubstr("sun"));
    EXPECT_THAT(refusal([](BakedScene& b) { b.groups[1].unitLux = 0.0f; }), HasSubstr("unit"));
    EXPECT_THAT(refusal([](BakedScene& b) { b.groups[1].radiance.pop_back(); }), HasSubstr("probes"));
    EXPECT_THAT(refusal([](BakedScene& b) { b.scene.lights[0].baking.group = 4; }), HasSubstr("ceiling lamp"));
    EXPECT_THAT(refusal([](BakedScene& b) { b.scene.materials[0].bakedGroup = 9; }), HasSubstr("group"));
    EXPECT_THAT(refusal([](BakedScene& b) { b.groups.resize(17, b.groups[0]); }), HasSubstr("16"));
    EXPECT_EQ(refusal([](BakedScene& b) { b.groups[0].directions.clear(); }), "loaded");
}

} // namespace
} // namespace halflight::test::light_weights_test
