// S33. Pictures of states of light groups: those of the bake that composeGroups() makes of the weights, and of
// closed forms.
#include "bake/test_sky.h"
#include "render/scene/light_groups_scene.h"

#include "halflight/render/probes.h"
#include "halflight/shading/sh.h"

namespace halflight::test::light_groups_test {
namespace {

class LightGroupPicturesS33 : public BothPaths {
protected:
    void SetUp() override
    {
        BothPaths::SetUp();
        settings.mode = RunMode::Shadowmask;
        settings.path = GetParam();
        settings.size = {192, 108};
        settings.shadows.directionalMapSize = 512;
    }
    RenderedFrame draw() { return render(camera, settings); }
    void set(const std::vector<GroupWeight>& changes)
    {
        for (const GroupWeight& change : changes) ASSERT_TRUE(renderer->setLightGroup(change.name, change.weight));
    }
    /// The picture after these changes against that of the composed bake. Other groups keep their saved weights.
    void expectState(const BakedScene& baked, const std::vector<GroupWeight>& changes, const std::string& what)
    {
        ASSERT_TRUE(renderer->load(baked));
        draw();
        set(changes);
        const RenderedFrame changed = draw();
        const RenderedFrame composed = render(stateOf(baked, changes), camera, settings);
        const PictureDifference difference = compare(composed.radiance, changed.radiance);
        EXPECT_EQ(difference.differing, 0)
            << what << ": " << difference.worstRelative << " at " << difference.worst.x << ", " << difference.worst.y;
        EXPECT_EQ(changed.plan.warnings, composed.plan.warnings) << what;
    }

    RenderSettings settings;
    Camera camera = lookAt(vec3(0, 5, 7), vec3(0, 0.3f, 0));
};
INSTANTIATE_TEST_SUITE_P(, LightGroupPicturesS33, kBothPaths, pathNameOf);

TEST_P(LightGroupPicturesS33, AreThoseOfTheComposedBake)
{
    for (const bool directional : {false, true}) {
        const BakedScene baked = groupedScene(directional);
        const std::string which = directional ? " with directions" : "";
        expectState(baked, {}, "as saved" + which);
        expectState(baked, kAllGroupsOff, "all off" + which);
        for (const GroupWeight& group : kAllGroupsOff) {
            std::vector<GroupWeight> alone = kAllGroupsOff;
            alone.push_back({group.name, vec3(10.0f, 7.0f, 4.0f)});
            expectState(baked, alone, group.name + " alone at 10" + which);
        }
        expectState(baked, {{"neon", vec3(1, 0, 0.1f)}, {"day", vec3(0.2f, 0.1f, 0.05f)}}, "evening" + which);
    }
}

TEST_P(LightGroupPicturesS33, RealtimeModeFollowsToo)
{
    settings.mode = RunMode::Realtime;
    expectState(groupedScene(), {{"day", vec3(0.1f, 0.2f, 2.0f)}, {"lamp", vec3(3.0f)}}, "realtime");
}

// A room with one lamp and no rest: weight 0 is black, weight 10 is ten times as bright, whatever came between.
TEST_P(LightGroupPicturesS33, OneLampOffIsBlackAndAtTenTenfold)
{
    BakedScene baked = groupedScene();
    baked.scene.sky = {};
    baked.scene.lights.resize(1);
    for (Image<uint32_t>& page : baked.lightmaps) page = Image<uint32_t>(16, 16);
    for (Probe& probe : baked.probes.probes) probe.radiance = {};
    baked.groups.resize(1);
    baked.scene.materials[1].bakedGroup = -1;
    baked.scene.materials[1].emissiveNits = vec3(0);
    ASSERT_TRUE(renderer->load(baked));
    set({{"lamp", vec3(1.0f)}});
    const ImageRgba32f one = draw().radiance;
    set({{"lamp", vec3(0.0f)}});
    const ImageRgba32f off = draw().radiance;
    for (const vec4& pixel : off.texels()) ASSERT_EQ(vec3(pixel), vec3(0.0f));
    set({{"lamp", vec3(10.0f)}});
    ImageRgba32f ten = draw().radiance;
    for (vec4& pixel : ten.texels()) pixel = vec4(vec3(pixel) / 10.0f, pixel.w);
    const PictureDifference difference = compare(one, ten);
    EXPECT_EQ(difference.differing, 0) << difference.worstRelative;
    EXPECT_GT(difference.lit, 2000);
}

// The floor's pixels by hand: the rest's texel and the group's times its weight, times the BRDF.
TEST_P(LightGroupPicturesS33, FloorIsTheWeightedSum)
{
    BakedScene baked = groupedScene();
    baked.scene.sky = {};
    const Image<uint32_t> rest(16, 16, packRgb9e5(vec3(0.5f, 0.25f, 1.0f)));
    const Image<uint32_t> light(16, 16, packRgb9e5(vec3(2.0f, 4.0f, 8.0f)));
    baked.lightmaps[1] = rest;
    baked.groups[kLampWithPlate].lightmaps[1] = light;
    ASSERT_TRUE(renderer->load(baked));
    set(kAllGroupsOff);
    const vec3 weight(0.5f, 1.5f, 0.125f);
    set({{"neon", weight}});
    const ImageRgba32f picture = draw().radiance;
    for (const vec3 place : {vec3(-1, 0, 2), vec3(3, 0, -1), vec3(-3, 0, -3)}) {
        const ivec2 pixel = pixelOf(camera, settings.size, place);
        const Ray ray = pixelRay(camera, settings.size, pixel);
        const ShadedPoint point{onPlane(ray, 0.0f), vec3(0, 1, 0), -ray.direction, vec3(0.6f, 0.5f, 0.4f)};
        const vec3 expected = indirectRadiance(point, vec3(0.5f, 0.25f, 1.0f) + weight * vec3(2.0f, 4.0f, 8.0f));
        EXPECT_TRUE(near(vec3(picture(pixel.x, pixel.y)), expected, 4.0e-3f));
    }
}

// Probes are added up before ringing is removed: the light of an object by itself and in a sum differ, and both are
// what sampleProbes() says of the composed bake.
TEST_P(LightGroupPicturesS33, ObjectsHaveTheComposedProbesLight)
{
    const BakedScene baked = groupedScene();
    std::vector<GroupWeight> alone = kAllGroupsOff;
    alone.push_back({"lamp", vec3(2.0f)});
    BakedScene composed = stateOf(baked, alone);
    for (Probe& probe : composed.probes.probes) // ringing is really removed here
        EXPECT_NE(withoutRinging(probe.radiance), probe.radiance);
    settings.mode = RunMode::BakedIndirect;
    ASSERT_TRUE(renderer->load(baked));
    set(alone);
    Light moved = renderer->scene().lights[0]; // below the floor, where its direct light is behind all surfaces
    moved.worldFromLight = lightPose(vec3(0, -5, 0), vec3(0, -1, 0));
    ASSERT_TRUE(renderer->setLight(0, moved));
    const ImageRgba32f picture = draw().radiance;
    const ivec2 pixel = pixelOf(camera, settings.size, vec3(1.5f, 0.5f, 1));
    const Ray ray = pixelRay(camera, settings.size, pixel);
    const ShadedPoint point{onPlane(ray, 0.5f), vec3(0, 1, 0), -ray.direction, vec3(0.6f, 0.5f, 0.4f)};
    const ProbeSample sample = sampleProbes(composed, vec3(1.5f, 0.5f, 1));
    vec3 irradiance(0.0f);
    for (int i = 0; i < 9; ++i)
        irradiance += sample.radiance[std::size_t(i)] * shading::shIrradianceWeight(i, vec3(0, 1, 0));
    const vec3 seen(picture(pixel.x, pixel.y));
    const vec3 expected = indirectRadiance(point, irradiance);
    // The mirror reads the probes in another direction, which is a few per cent on a dull surface.
    EXPECT_TRUE(near(seen, expected, 0.08f)) << expected.x;
}

// The sky's picture is multiplied where it is read: by direction, in realtime mode's light, and as the bake's composer
// does it, which rounds the texels once more (so that a grey factor is compared).
TEST_P(LightGroupPicturesS33, SkyPictureFollows)
{
    const auto smooth = [](vec3 d) { return vec3(2.0f) + d; };
    BakedScene baked = groupedScene();
    baked.scene.sky = skyOf(skyPicture(512, smooth));
    baked.groups[kDay].weight = vec3(2.0f, 1.0f, 1.0f);
    camera = lookAt(vec3(0, 2, 7), vec3(0, 4, 0));
    ASSERT_TRUE(renderer->load(baked));
    set({{"day", vec3(0.5f, 3.0f, 0.01f)}});
    const ImageRgba32f tinted = draw().radiance;
    for (const ivec2 pixel : {ivec2(10, 5), ivec2(96, 20), ivec2(180, 2)}) {
        const vec3 direction = pixelRay(camera, settings.size, pixel).direction;
        const vec3 expected = smooth(direction) * vec3(0.25f, 3.0f, 0.01f);
        EXPECT_TRUE(near(vec3(tinted(pixel.x, pixel.y)), expected, 6.0e-3f));
    }
    expectState(baked, {{"day", vec3(0.5f, 0.25f, 0.25f)}}, "dimmed");
    expectState(baked, {{"day", vec3(0.0f)}}, "black");
    settings.mode = RunMode::Realtime;
    expectState(baked, {{"day", vec3(0.5f, 0.25f, 0.25f)}}, "dimmed, realtime");
}

// A sky that is black in a channel was baked white there: its light and the drawn sky appear together.
TEST_P(LightGroupPicturesS33, BlackChannelOfTheSkyBecomesWhite)
{
    BakedScene baked = groupedScene();
    baked.scene.sky.zenith = baked.scene.sky.horizon = baked.scene.sky.ground = vec3(0.0f, 0.25f, 0.5f);
    baked.groups[kDay].weight = vec3(0.0f, 0.5f, 1.0f);
    camera = lookAt(vec3(0, 2, 7), vec3(0, 9, 0));
    ASSERT_TRUE(renderer->load(baked));
    set({{"day", vec3(1.0f)}});
    EXPECT_TRUE(near(vec3(draw().radiance(96, 54)), vec3(0.5f)));
    set({{"day", vec3(3.0f, 0.0f, 0.0f)}});
    EXPECT_TRUE(near(vec3(draw().radiance(96, 54)), vec3(1.5f, 0.0f, 0.0f)));
}

} // namespace
} // namespace halflight::test::light_groups_test
