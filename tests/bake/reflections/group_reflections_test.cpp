// S33. Reflection probes of light groups: pictures of each, and states of them against bakes of the changed lights.

#include "bake/lights/group_states.h"

#include "halflight/base/rgb9e5.h"
#include "halflight/shading/reflection.h"

#include <filesystem>

namespace halflight::test::group_reflections_test {
namespace {

/// A closed room with a red neon strip and a mixed lamp, which are groups, and a candle.
Scene room()
{
    Scene scene;
    const int grey = addMaterial(scene, vec3(0.5f));
    const int neon = addMaterial(scene, vec3(0.0f), vec3(40, 4, 4));
    scene.materials[std::size_t(neon)].group = "neon";
    scene.materials[std::size_t(neon)].name = "neon";
    addBox(scene, vec3(-2, 0, -1.5f), vec3(2, 2.5f, 1.5f), grey, true);
    addBox(scene, vec3(-1.5f, 2.0f, -1.4f), vec3(1.5f, 2.2f, -1.2f), neon, false);
    Light lamp = makeLight(LightType::Point, vec3(1, 2, 0.5f), vec3(0, -1, 0), 20.0f, LightMode::Mixed);
    lamp.name = lamp.group = "lamp";
    scene.lights.push_back(lamp);
    Light candle = makeLight(LightType::Point, vec3(-1, 0.5f, 0.5f), vec3(0, -1, 0), 10.0f, LightMode::Baked);
    candle.name = "candle";
    scene.lights.push_back(candle);
    scene.reflectionBoxes = {mat4(vec4(2, 0, 0, 0), vec4(0, 1.25f, 0, 0), vec4(0, 0, 1.5f, 0), vec4(0, 1.25f, 0, 1))};
    return scene;
}

BakeSettings settingsOf(GroupChoice groups)
{
    BakeSettings settings;
    settings.quality = Quality::Preview;
    settings.samples = 64;
    settings.lightmapSize = 128;
    settings.probeSpacingMeters = 1.5f;
    settings.probeLayout = ProbeLayout::Grid;
    settings.groups = groups;
    return settings;
}

ImageRgb32f pictureOf(const BakedScene& baked)
{
    return decodeRgb9e5(baked.reflections.picture, baked.reflections.unitNits);
}

/// Mean absolute difference of luminance over the truth's mean, of the sharpest level's map or of a rougher one.
double offBy(const BakedScene& state, const BakedScene& truth, int level)
{
    const ImageRgb32f a = pictureOf(state);
    const ImageRgb32f b = pictureOf(truth);
    EXPECT_EQ(a.size(), b.size());
    const int size = truth.reflections.size;
    const ivec2 corner(shading::reflectionLevelOffset(size, level));
    double off = 0.0;
    double sum = 0.0;
    for (int y = 0; y < shading::reflectionLevelSize(size, level); ++y) {
        for (int x = 0; x < shading::reflectionLevelSize(size, level); ++x) {
            const ivec2 at = corner + ivec2(x, y);
            off += std::abs(double(luminance(a(at.x, at.y))) - double(luminance(b(at.x, at.y))));
            sum += double(luminance(b(at.x, at.y)));
        }
    }
    return off / sum;
}

class GroupReflectionsS33 : public testing::Test {
protected:
    static const BakeResult& grouped()
    {
        static const BakeResult once = bakeOf(room(), settingsOf(GroupChoice::Authored));
        return once;
    }
};

TEST_F(GroupReflectionsS33, PicturesAreHalfAsWide)
{
    const BakedScene& baked = grouped().baked;
    ASSERT_EQ(baked.reflections.probes.size(), 1u);
    for (const BakedGroup& group : baked.groups) {
        EXPECT_EQ(group.reflections.size, std::max(baked.reflections.size / 2, 32)) << group.name;
        EXPECT_TRUE(group.reflections.probes.empty());
        EXPECT_EQ(group.reflections.picture.size(),
                  ivec2(group.reflections.size, shading::reflectionTileHeight(group.reflections.size)));
    }
}

TEST_F(GroupReflectionsS33, AStateIsABakeOfIt)
{
    struct State {
        const char* name;
        std::vector<GroupWeight> weights;
        vec3 neon;
        float lamp;
    };
    const std::vector<State> states = {
        {"as saved", {}, vec3(40, 4, 4), 20.0f},
        {"no neon", {{"neon", vec3(0)}}, vec3(0), 20.0f},
        {"blue neon alone", {{"neon", vec3(0, 0, 2)}, {"lamp", vec3(0)}}, vec3(0, 0, 80), 0},
        {"candle alone", {{"neon", vec3(0)}, {"lamp", vec3(0)}}, vec3(0), 0}};
    for (const State& state : states) {
        Scene changed = room();
        changed.materials[1].emissiveNits = state.neon;
        changed.lights[0].intensity = state.lamp;
        const BakeResult own = bakeOf(changed, settingsOf(GroupChoice::Off));
        const BakedScene composed = stateOf(grouped().baked, state.weights);
        // Edges of the strip and of shadows are as sharp as the group's texels.
        EXPECT_LT(offBy(composed, own.baked, 0), 0.12) << state.name;
        EXPECT_LT(offBy(composed, own.baked, 2), 0.05) << state.name;
    }
}

TEST_F(GroupReflectionsS33, ADimGroupHasNoPicture)
{
    Scene scene = room();
    scene.lights[0].intensity = 0.01f;
    const BakeResult result = bakeOf(scene, settingsOf(GroupChoice::Authored));
    const BakedScene& baked = result.baked;
    EXPECT_EQ(baked.groups[groupNamed(baked, "lamp")].reflections.size, 0);
    EXPECT_GT(baked.groups[groupNamed(baked, "neon")].reflections.size, 0);
    const auto lampOff = *groupWeights(baked, {{"lamp", vec3(0)}});
    EXPECT_EQ(groupsKeptByReflections(baked, lampOff), std::vector<std::string>{"lamp"});
    EXPECT_TRUE(groupsKeptByReflections(baked, *groupWeights(baked, {{"neon", vec3(0)}})).empty());
}

TEST_F(GroupReflectionsS33, AFileKeepsPictures)
{
    const std::filesystem::path file = std::filesystem::temp_directory_path() / "halflight_group_reflections.glb";
    ASSERT_TRUE(writeBakedScene(file, grouped().baked));
    const Result<BakedScene> read = readBakedScene(file);
    ASSERT_TRUE(read) << read.error().text();
    const std::vector<GroupWeight> change = {{"neon", vec3(0.3f)}};
    const BakedScene now = stateOf(grouped().baked, change);
    EXPECT_EQ(pictureOf(now).texels(), pictureOf(stateOf(*read, change)).texels());
    std::filesystem::remove(file);
}

/// One light everywhere: every texel of every level has the sum, borders included.
TEST(ComposedReflectionsS33, EvenLightStaysEven)
{
    BakedScene baked;
    const auto tile = [](int size, vec3 light) {
        ImageRgb32f picture(size, 2 * shading::reflectionTileHeight(size));
        for (vec3& texel : picture.texels()) texel = light;
        ReflectionSet set;
        set.size = size;
        set.picture = encodeRgb9e5(picture, 1.0f);
        return set;
    };
    baked.reflections = tile(96, vec3(1.0f));
    baked.reflections.probes.resize(2);
    BakedGroup& group = baked.groups.emplace_back();
    group.name = "lamp";
    group.reflections = tile(48, vec3(2.0f, 4.0f, 8.0f));
    composeGroups(baked, {vec3(0.5f)});
    const ImageRgb32f sum = pictureOf(baked);
    for (int probe = 0; probe < 2; ++probe) {
        for (int level = 0; level < shading::kReflectionLevels; ++level) {
            const ivec2 corner(shading::reflectionLevelOffset(96, level));
            const int width = shading::reflectionLevelSize(96, level);
            for (const ivec2 at : {ivec2(0), ivec2(width - 1), ivec2(width / 2, 0), ivec2(1, width / 3)}) {
                const ivec2 texel = corner + at + ivec2(0, probe * shading::reflectionTileHeight(96));
                EXPECT_NEAR(sum(texel.x, texel.y).z, 5.0f, 0.02f) << level;
                EXPECT_NEAR(sum(texel.x, texel.y).x, 2.0f, 0.02f) << level;
            }
        }
    }
}

} // namespace
} // namespace halflight::test::group_reflections_test
