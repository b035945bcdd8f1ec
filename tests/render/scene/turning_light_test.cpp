// S34. A light that turns, in the renderer: bounced light follows it, its shadows are realtime.
#include "render/scene/light_groups_scene.h"

#include "halflight/scene/turning_lights.h"

#include <gmock/gmock.h>

#include <cmath>

namespace halflight::test::turning_light_test {
namespace {

using testing::Contains;
using testing::HasSubstr;

const std::vector<vec3> kDirections = {glm::normalize(vec3(-0.3f, -1, 0)), glm::normalize(vec3(0.05f, -1, 0.1f)),
                                       glm::normalize(vec3(0.4f, -1, 0))};

/// The sun has three directions in place of a group and a mask. It shines along the second one.
BakedScene turningScene()
{
    BakedScene baked = groupedScene(true);
    const BakedGroup sun = baked.groups[kSun];
    const vec3 lights[] = {vec3(3, 1, 0.5f), vec3(1, 3, 0.5f), vec3(0.5f, 1, 3)};
    for (std::size_t d = 0; d < kDirections.size(); ++d) {
        BakedGroup& own = baked.groups.emplace_back(sun);
        own.name = nameOfDirection("the sun", d);
        own.weight = d == 1 ? sun.weight : vec3(0.0f);
        for (uint32_t& texel : own.lightmaps[1].texels()) texel = packRgb9e5(unpackRgb9e5(texel) * lights[d]);
    }
    Light& light = baked.scene.lights[1];
    light.baking.group = -1;
    light.baking.occlusionMaskChannel = -1;
    light.baking.turning = {4, kDirections};
    light.worldFromLight = light.baking.worldFromLight = lightPose(vec3(0), kDirections[1]);
    baked.groups[kSun].name = "nobody";
    baked.groups[kSun].weight = vec3(0.0f);
    return baked;
}

class TurningLightS34 : public RenderTest {
protected:
    void SetUp() override
    {
        RenderTest::SetUp();
        settings.mode = RunMode::Shadowmask;
        settings.size = {96, 54};
        settings.shadows.directionalMapSize = 256;
        baked = turningScene();
        ASSERT_TRUE(renderer->load(baked));
    }
    RenderedFrame draw() { return render(camera, settings); }
    Status turn(vec3 direction)
    {
        Light light = renderer->scene().lights[1];
        light.worldFromLight = lightPose(vec3(0), direction);
        return renderer->setLight(1, light);
    }
    /// Of a file without groups, composed for this direction.
    RenderedFrame composed(vec3 direction, const std::vector<GroupWeight>& changes = {})
    {
        BakedScene state = baked;
        state.scene.lights[1].worldFromLight = lightPose(vec3(0), direction);
        EXPECT_TRUE(renderer->load(stateOf(state, changes)));
        return draw();
    }

    RenderSettings settings;
    Camera camera = lookAt(vec3(0, 5, 7), vec3(0, 0.3f, 0));
    BakedScene baked;
};

TEST_F(TurningLightS34, BouncedLightIsThatOfTheDirection)
{
    draw();
    std::vector<RenderedFrame> turned;
    const std::vector<vec3> directions = {kDirections[0], glm::normalize(vec3(-0.15f, -1, 0.05f)),
                                          glm::normalize(vec3(0.2f, -1, 0.02f))};
    for (const vec3 direction : directions) {
        ASSERT_TRUE(turn(direction));
        turned.push_back(draw());
        EXPECT_EQ(composePassesOf(turned.back()), 1);
        EXPECT_EQ(composePassesOf(draw()), 0) << "the light rests";
        EXPECT_THAT(turned.back().plan.warnings, testing::Not(Contains(HasSubstr("moved after the bake"))));
    }
    EXPECT_GT(compare(turned[0].radiance, turned[2].radiance).differing, 100);
    for (std::size_t i = 0; i < directions.size(); ++i) {
        const RenderedFrame truth = composed(directions[i]);
        for (std::size_t p = 0; p < truth.radiance.texelCount(); ++p) // mantissae of nine bits
            EXPECT_TRUE(near(vec3(turned[i].radiance.data()[p]), vec3(truth.radiance.data()[p]), 0.01f)) << i;
    }
}

TEST_F(TurningLightS34, IsOneGroupOfItsName)
{
    std::vector<std::string> names;
    for (const GroupWeight& group : renderer->lightGroups()) names.push_back(group.name);
    EXPECT_EQ(names, (std::vector<std::string>{"lamp", "nobody", "day", "neon", "the sun"}));
    ASSERT_TRUE(turn(glm::normalize(vec3(-0.1f, -1, 0))));
    ASSERT_TRUE(renderer->setLightGroup("the sun", vec3(2, 1, 0)));
    const Light& light = renderer->scene().lights[1];
    EXPECT_TRUE(near(light.color * light.intensity, vec3(12, 6, 0)));
    EXPECT_TRUE(near(renderer->lightGroups()[4].weight, vec3(2, 1, 0)));
    Light dimmed = light;
    dimmed.intensity *= 0.5f;
    ASSERT_TRUE(renderer->setLight(1, dimmed));
    EXPECT_TRUE(near(renderer->lightGroups()[4].weight, vec3(1, 0.5f, 0)));
    EXPECT_THAT(renderer->setLightGroup("the sun.2", vec3(1)).error().message, HasSubstr("or set \"the sun\""));
    EXPECT_THAT(renderer->setLightGroup("moon", vec3(1)).error().message, HasSubstr("neon, the sun"));
    // Turned away from all directions, it still can be dimmed and brought back.
    ASSERT_TRUE(turn(vec3(0, 1, 0)));
    ASSERT_TRUE(renderer->setLightGroup("the sun", vec3(0.5f)));
    EXPECT_TRUE(near(light.color * light.intensity, vec3(3)));
    EXPECT_THAT(draw().plan.warnings, Contains(HasSubstr("degrees away from the nearest direction of its bake")));
}

TEST_F(TurningLightS34, MissingShadowsAreNamed)
{
    const auto isNamed = Contains(HasSubstr("light \"the sun\" turns, so that it has no baked shadows: beyond the "
                                            "shadow distance of 5 m it throws none"));
    EXPECT_THAT(draw().plan.warnings, testing::Not(Contains(HasSubstr("no baked shadows"))));
    settings.shadows.distanceMeters = 5.0f;
    settings.shadows.fadeRangeMeters = 1.0f;
    EXPECT_THAT(draw().plan.warnings, isNamed);
    settings.mode = RunMode::DistanceShadowmask;
    EXPECT_THAT(draw().plan.warnings, isNamed);
    settings.lightRows = true;
    EXPECT_EQ(draw().lights[1].noBakedShadow, "it turns, so that its shadows are realtime");
}

} // namespace
} // namespace halflight::test::turning_light_test
