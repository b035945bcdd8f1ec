// S33. Light groups of subtractive bakes: the main light's direct light, and the lower limit of its shadows.

#include "bake/lights/group_states.h"

namespace halflight::test::subtractive_groups_test {
namespace {

/// A wall on open ground that throws a shadow. The sun and a lamp are groups, the sky is the rest.
Scene wall()
{
    Scene scene;
    const int grey = addMaterial(scene, vec3(0.4f));
    addBox(scene, vec3(-6, -0.2f, -6), vec3(6, 0, 6), grey, false);
    addBox(scene, vec3(-2, 0, -0.1f), vec3(2, 2, 0.1f), grey, false);
    Light sun = makeLight(LightType::Directional, vec3(0), vec3(0, -1, -1), 100.0f, LightMode::Mixed);
    sun.name = sun.group = "sun";
    sun.color = vec3(1.0f, 0.8f, 0.5f);
    scene.lights.push_back(sun);
    Light lamp = makeLight(LightType::Point, vec3(0, 1, -2), vec3(0, -1, 0), 50.0f, LightMode::Baked);
    lamp.name = lamp.group = "lamp";
    scene.lights.push_back(lamp);
    scene.sky = Sky{vec3(10), vec3(5), vec3(0)};
    return scene;
}

BakeSettings settingsOf(GroupChoice groups)
{
    BakeSettings settings;
    settings.mode = MixedLightingMode::Subtractive;
    settings.quality = Quality::Preview;
    settings.samples = 64;
    settings.lightmapSize = 256;
    settings.probeSpacingMeters = 3.0f;
    settings.probeLayout = ProbeLayout::Grid;
    settings.reflectionProbes = false;
    settings.directional = true;
    settings.groups = groups;
    return settings;
}

class SubtractiveGroupsS33 : public testing::Test {
protected:
    static const BakeResult& grouped()
    {
        static const BakeResult once = bakeOf(wall(), settingsOf(GroupChoice::Authored));
        return once;
    }
};

TEST_F(SubtractiveGroupsS33, TheSavedStateIsTheBakeWithoutGroups)
{
    const BakeResult plain = bakeOf(wall(), settingsOf(GroupChoice::Off));
    const BakedScene state = stateOf(grouped().baked, {});
    EXPECT_NEAR(meanOf(pagesOf(state)) / meanOf(pagesOf(plain.baked)), 1.0, 0.003);
    EXPECT_LT(errorOf(pagesOf(state), pagesOf(plain.baked)), 0.04);
    ASSERT_EQ(state.shadowmasks.size(), plain.baked.shadowmasks.size());
    for (std::size_t p = 0; p < state.shadowmasks.size(); ++p)
        EXPECT_EQ(state.shadowmasks[p].texels(), plain.baked.shadowmasks[p].texels());
    for (int c = 0; c < 3; ++c) {
        const float truth = plain.baked.defaultShadowColor[c];
        EXPECT_GT(truth, 0.0f);
        EXPECT_NEAR(state.defaultShadowColor[c] / truth, 1.0f, 0.25f) << "sums of quantiles are about the sum's";
    }
}

TEST_F(SubtractiveGroupsS33, TheMainLightFollowsItsWeight)
{
    // A white sun, twice as bright, without the lamp.
    const BakedScene state = stateOf(grouped().baked, {{"sun", vec3(2)}, {"lamp", vec3(0)}});
    Scene changed = wall();
    changed.lights[0].color = vec3(1);
    changed.lights[0].intensity = 200.0f;
    changed.lights[1].intensity = 0.0f;
    const BakeResult own = bakeOf(changed, settingsOf(GroupChoice::Off));
    EXPECT_NEAR(meanOf(pagesOf(state)) / meanOf(pagesOf(own.baked)), 1.0, 0.005);
    EXPECT_LT(errorOf(pagesOf(state), pagesOf(own.baked)), 0.04);
    EXPECT_NEAR(state.scene.lights[0].intensity, 200.0f, 0.01f);
    EXPECT_EQ(state.scene.lights[0].baking.occlusionMaskChannel, 0);
    // Lit ground far from the wall has the sun's light by the cosine, as nothing bounces there.
    EXPECT_GT(state.defaultShadowColor.x, 0.0f);
}

TEST_F(SubtractiveGroupsS33, ShadowsFollowTheWeights)
{
    const BakedScene& baked = grouped().baked;
    const BakedGroup& lamp = baked.groups[groupNamed(baked, "lamp")];
    const vec3 rest = stateOf(baked, {{"sun", vec3(0)}, {"lamp", vec3(0)}}).defaultShadowColor;
    EXPECT_EQ(rest, baked.defaultShadowColor);
    EXPECT_GT(rest.x, 0.0f) << "of the sky";
    const vec3 lit = stateOf(baked, {{"sun", vec3(0)}, {"lamp", vec3(3, 2, 1)}}).defaultShadowColor;
    for (int c = 0; c < 3; ++c) EXPECT_FLOAT_EQ(lit[c], rest[c] + vec3(3, 2, 1)[c] * lamp.shadowColor[c]);
    EXPECT_EQ(subtractiveShadowColor(baked), stateOf(baked, {}).defaultShadowColor) << "at the saved weights";
    BakedScene authored = baked;
    authored.scene.subtractiveShadowColor = vec3(7);
    EXPECT_EQ(subtractiveShadowColor(stateOf(authored, {{"lamp", vec3(9)}})), vec3(7)) << "the author's stays";
}

TEST_F(SubtractiveGroupsS33, AFileKeepsTheLimits)
{
    const std::filesystem::path file = std::filesystem::temp_directory_path() / "halflight_subtractive_groups.glb";
    ASSERT_TRUE(writeBakedScene(file, grouped().baked));
    const Result<BakedScene> read = readBakedScene(file);
    ASSERT_TRUE(read) << read.error().text();
    for (std::size_t g = 0; g < read->groups.size(); ++g)
        EXPECT_EQ(read->groups[g].shadowColor, grouped().baked.groups[g].shadowColor);
    EXPECT_EQ(read->defaultShadowColor, grouped().baked.defaultShadowColor);
    std::filesystem::remove(file);
}

} // namespace
} // namespace halflight::test::subtractive_groups_test
