// S34. A sky that changes: its parts as light groups, with their closed forms, and states of them.

#include "bake/lights/group_states.h"

#include <gmock/gmock.h>

#include <glm/gtc/constants.hpp>

namespace halflight::test::sky_groups_test {
namespace {

constexpr float kPi = glm::pi<float>();
constexpr int kPage = 64;

Sky changingSky()
{
    Sky sky{vec3(400, 600, 1000), vec3(800), vec3(0)};
    sky.changes = true;
    return sky;
}

/// A black rectangle in the open.
Scene inTheOpen(const Rectangle& rectangle)
{
    Scene scene;
    const int black = addMaterial(scene, vec3(0.0f));
    addRectangle(scene, rectangle, black, kPage, {vec2(4), vec2(60)});
    scene.meshes[0].parts[0].uv[1] = scene.meshes[0].parts[0].lightmapUv; // UvMode::Keep
    scene.sky = changingSky();
    return scene;
}

BakeSettings settingsOf()
{
    BakeSettings settings;
    settings.samples = 256;
    settings.lightmapSize = kPage;
    settings.uvMode = UvMode::Keep;
    settings.probeLayout = ProbeLayout::Grid;
    settings.reflectionProbes = false;
    settings.directional = false;
    return settings;
}

/// Mean of the lit texels of a group, lux by channel.
vec3 irradianceOf(const BakeResult& result, const std::string& group)
{
    dvec3 sum(0.0);
    double count = 0.0;
    const ImageRgb32f& page = result.groupIrradiance[groupNamed(result.baked, group)][0];
    for (int y = 8; y < 56; ++y)
        for (int x = 8; x < 56; ++x) sum += dvec3(page(x, y)), count += 1.0;
    return vec3(sum / count);
}

void expectNear(vec3 value, float truth, const char* what)
{
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(value[c], truth, 0.01f * std::max(truth, 0.1f)) << what;
}

TEST(SkyGroupsS34, OpenGroundHasTheClosedForms)
{
    const BakeResult result = bakeOf(inTheOpen({vec3(-1, 0, 1), vec3(2, 0, 0), vec3(0, 0, -2)}), settingsOf());
    ASSERT_EQ(result.baked.groups.size(), 3u);
    expectNear(irradianceOf(result, "sky.zenith"), 2.0f * kPi / 3.0f, "zenith");
    expectNear(irradianceOf(result, "sky.horizon"), kPi / 3.0f, "horizon");
    expectNear(irradianceOf(result, "sky.ground"), 0.0f, "ground");
}

TEST(SkyGroupsS34, AFreeWallHasTheClosedForms)
{
    const BakeResult result = bakeOf(inTheOpen({vec3(-1, 0, 0), vec3(2, 0, 0), vec3(0, 2, 0)}), settingsOf());
    expectNear(irradianceOf(result, "sky.zenith"), 2.0f / 3.0f, "zenith");
    expectNear(irradianceOf(result, "sky.horizon"), kPi - 4.0f / 3.0f, "horizon");
    expectNear(irradianceOf(result, "sky.ground"), 2.0f / 3.0f, "ground");
}

TEST(SkyGroupsS34, WeightsAreRadiances)
{
    const BakeResult result = bakeOf(inTheOpen({vec3(-1, 0, 1), vec3(2, 0, 0), vec3(0, 0, -2)}), settingsOf());
    const auto weightOf = [&](const char* group) {
        return result.baked.groups[groupNamed(result.baked, group)].weight;
    };
    const auto expectWeight = [&](const char* group, vec3 nits) {
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(weightOf(group)[c], nits[c], 1e-3f) << group;
    };
    expectWeight("sky.zenith", vec3(400, 600, 1000));
    expectWeight("sky.horizon", vec3(800));
    expectWeight("sky.ground", vec3(0));
    for (const BakedGroup& group : result.baked.groups) EXPECT_TRUE(group.sky);
    EXPECT_EQ(result.baked.scene.sky.zenith, vec3(400, 600, 1000)) << "the scene has its own light again";
    // In the open a probe has the integrals of the basis: pi, 2 pi and pi, times the constant harmonic.
    const std::array truths = {kPi, 2.0f * kPi, kPi};
    for (std::size_t part = 0; part < truths.size(); ++part) {
        float sum = 0.0f;
        const BakedGroup& group = result.baked.groups[part];
        ASSERT_FALSE(group.radiance.empty());
        std::size_t above = 0;
        for (std::size_t i = 0; i < group.radiance.size(); ++i) {
            if (!(result.baked.probes.probes[i].position.y > 0.0f)) continue;
            sum += group.radiance[i][0].y;
            ++above;
        }
        ASSERT_GT(above, 0u);
        // The rectangle hides what is below the horizon.
        const float truth = 0.2820948f * truths[part];
        if (part == 0) {
            EXPECT_GT(sum / float(above), 0.95f * truth);
        }
        EXPECT_LT(sum / float(above), 1.05f * truth) << part;
    }
}

/// A court with a sunlit wall, so that light of the sky bounces.
Scene court()
{
    Scene scene;
    const int grey = addMaterial(scene, vec3(0.6f));
    addBox(scene, vec3(-2, 0, -2), vec3(2, 3, 2), grey, true);
    scene.meshes.pop_back();
    scene.objects.pop_back(); // open above or to a side
    addBox(scene, vec3(-1, 0, -1), vec3(0, 1, 0), grey, false);
    scene.lights.push_back(
        makeLight(LightType::Directional, vec3(0), vec3(-0.4f, -1, 0.2f), 3000.0f, LightMode::Baked));
    scene.sky = changingSky();
    return scene;
}

TEST(SkyGroupsS34, AnotherSkyIsABakeOfIt)
{
    BakeSettings settings = settingsOf();
    settings.uvMode = UvMode::Auto;
    settings.lightmapSize = 128;
    settings.samples = 64;
    const BakeResult result = bakeOf(court(), settings);
    const BakedScene state =
        stateOf(result.baked, {{"sky", vec3(0)}, {"sky.horizon", vec3(3000, 1500, 500)}, {"sky.ground", vec3(200)}});
    Scene evening = court();
    evening.sky = Sky{vec3(0), vec3(3000, 1500, 500), vec3(200)};
    EXPECT_EQ(state.scene.sky.zenith, evening.sky.zenith) << "the drawn sky follows";
    EXPECT_EQ(state.scene.sky.horizon, evening.sky.horizon);
    EXPECT_EQ(state.scene.sky.ground, evening.sky.ground);
    const BakeResult own = bakeOf(evening, settings);
    EXPECT_NEAR(meanOf(pagesOf(state)) / meanOf(pagesOf(own.baked)), 1.0, 0.01);
    EXPECT_LT(errorOf(pagesOf(state), pagesOf(own.baked)), 0.08);
}

TEST(SkyGroupsS34, APictureIsOneGroup)
{
    Scene scene = inTheOpen({vec3(-1, 0, 1), vec3(2, 0, 0), vec3(0, 0, -2)});
    ImageRgb32f picture(16, 8);
    for (vec3& texel : picture.texels()) texel = vec3(10, 20, 40);
    scene.sky.setPicture(std::make_shared<const ImageRgb32f>(picture), 0.0f);
    const BakeResult result = bakeOf(scene, settingsOf());
    ASSERT_EQ(result.baked.groups.size(), 1u);
    EXPECT_EQ(result.baked.groups[0].name, "sky.picture");
    EXPECT_EQ(result.baked.groups[0].weight, vec3(1));
    EXPECT_NEAR(irradianceOf(result, "sky.picture").z, 40.0f * kPi, 0.4f * kPi);
    const BakedScene state = stateOf(result.baked, {{"sky", vec3(0.5f, 1, 2)}});
    EXPECT_NEAR(state.scene.sky.picture->texels()[0].z, 80.0f, 1e-3f) << "brightness and tint";
    EXPECT_NEAR(pagesOf(state)[0](30, 30).x, 5.0f * kPi, 0.1f * kPi);
}

TEST(SkyGroupsS34, AFileKeepsThem)
{
    const std::filesystem::path file = std::filesystem::temp_directory_path() / "halflight_sky_groups_test.glb";
    const BakeResult result = bakeOf(inTheOpen({vec3(-1, 0, 1), vec3(2, 0, 0), vec3(0, 0, -2)}), settingsOf());
    ASSERT_TRUE(writeBakedScene(file, result.baked));
    const Result<BakedScene> read = readBakedScene(file);
    ASSERT_TRUE(read) << read.error().text();
    EXPECT_TRUE(read->scene.sky.changes) << "for the next bake";
    EXPECT_LT(errorOf(pagesOf(stateOf(*read, {})), pagesOf(stateOf(result.baked, {}))), 0.002);
    const auto weights = groupWeights(BakedScene(), {{"sky.zenith", vec3(1)}});
    ASSERT_FALSE(weights);
    EXPECT_THAT(weights.error().text(), testing::HasSubstr("halflight_sky_changes = 1"));
    std::filesystem::remove(file);
}

} // namespace
} // namespace halflight::test::sky_groups_test
