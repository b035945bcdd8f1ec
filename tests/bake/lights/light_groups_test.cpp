// S33. A bake with light groups: sums, each group alone, lamps that are off, shared materials, changed lights, files.

#include "bake/lights/group_states.h"
#include "bake/seeds.h"
#include "bake/test_scene.h"

#include "halflight/bake_cpu/embree_integrator.h"
#include "halflight/scene/gltf.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace halflight::test::bake_groups_test {
namespace {

using testing::HasSubstr;

const std::filesystem::path kRooms = std::filesystem::path(HALFLIGHT_SOURCE_DIR) / "assets/tests/light_groups.glb";

BakeSettings settingsOf(int samples = 64)
{
    BakeSettings settings;
    settings.quality = Quality::Preview;
    settings.samples = samples;
    settings.texelsPerMeter = 6.0f;
    settings.probeSpacingMeters = 1.5f;
    settings.probeLayout = ProbeLayout::Grid; // refinement follows white light
    settings.reflectionProbes = false;
    settings.directional = true;
    return settings;
}

Scene rooms()
{
    Result<Scene> scene = readScene(kRooms);
    EXPECT_TRUE(scene);
    return *scene;
}

const std::vector<GroupWeight> kAllOff = {
    {"lamp", vec3(0)}, {"sun", vec3(0)}, {"west", vec3(0)}, {"east", vec3(0)}, {"day", vec3(0)}};

class LightGroupsBakeS33 : public testing::Test {
protected:
    static void SetUpTestSuite()
    {
        grouped_ = new BakeResult(bakeOf(rooms(), settingsOf()));
        BakeSettings off = settingsOf();
        off.groups = GroupChoice::Off;
        plain_ = new BakeResult(bakeOf(rooms(), off));
    }
    static void TearDownTestSuite()
    {
        delete grouped_;
        delete plain_;
    }
    static BakeResult* grouped_;
    static BakeResult* plain_;
};
BakeResult* LightGroupsBakeS33::grouped_ = nullptr;
BakeResult* LightGroupsBakeS33::plain_ = nullptr;

TEST_F(LightGroupsBakeS33, HasAGroupForEachName)
{
    const BakedScene& baked = grouped_->baked;
    ASSERT_EQ(baked.groups.size(), 5u);
    EXPECT_EQ(baked.groups[groupNamed(baked, "lamp")].weight, vec3(1.0f, 0.1f, 0.05f));
    EXPECT_TRUE(baked.groups[groupNamed(baked, "day")].sky);
    for (const BakedGroup& group : baked.groups) {
        EXPECT_GT(group.peakLux, 0.0f) << group.name;
        EXPECT_EQ(group.radiance.size(), baked.probes.probes.size());
    }
    EXPECT_TRUE(plain_->baked.groups.empty());
}

TEST_F(LightGroupsBakeS33, TheSavedStateIsTheBakeWithoutGroups)
{
    const BakedScene state = stateOf(grouped_->baked, {});
    EXPECT_TRUE(state.groups.empty());
    EXPECT_NEAR(meanOf(pagesOf(state)) / meanOf(pagesOf(plain_->baked)), 1.0, 0.003);
    EXPECT_LT(errorOf(pagesOf(state), pagesOf(plain_->baked)), 0.08);
    for (std::size_t i = 0; i < state.scene.lights.size(); ++i) {
        EXPECT_EQ(state.scene.lights[i].color, plain_->baked.scene.lights[i].color);
        EXPECT_EQ(state.scene.lights[i].intensity, plain_->baked.scene.lights[i].intensity);
    }
    // The shadowmasks do not depend on groups.
    ASSERT_EQ(state.shadowmasks.size(), plain_->baked.shadowmasks.size());
    for (std::size_t p = 0; p < state.shadowmasks.size(); ++p)
        EXPECT_TRUE(std::ranges::equal(state.shadowmasks[p].texels(), plain_->baked.shadowmasks[p].texels()));
}

TEST(LightGroupsProbesS33, TheSavedStateIsTheBakeWithoutGroups)
{
    const SeedMean difference = overSeeds([](uint32_t seed) {
        BakeSettings settings = settingsOf(1); // no more for the lightmap
        settings.seed = seed;
        const BakedScene state = stateOf(bakeOf(rooms(), settings).baked, {});
        settings.groups = GroupChoice::Off;
        const ProbeSet plain = bakeOf(rooms(), settings).baked.probes;
        EXPECT_EQ(state.probes.probes.size(), plain.probes.size());
        double sum = 0.0;
        double more = 0.0;
        for (std::size_t i = 0; i < plain.probes.size(); ++i) {
            const double light = double(luminance(plain.probes[i].radiance[0]));
            sum += light;
            more += double(luminance(state.probes.probes[i].radiance[0])) - light;
        }
        return more / sum;
    });
    EXPECT_LE(difference.error, 0.03) << "of 64 paths a probe";
    EXPECT_NEAR(difference.mean, 0.0, 4.0 * difference.error);
}

TEST_F(LightGroupsBakeS33, WeightsAddUp)
{
    const BakedScene rest = stateOf(grouped_->baked, kAllOff);
    std::vector<ImageRgb32f> sum = pagesOf(rest);
    for (std::size_t g = 0; g < grouped_->baked.groups.size(); ++g)
        for (std::size_t p = 0; p < sum.size(); ++p)
            for (std::size_t i = 0; i < sum[p].texelCount(); ++i)
                sum[p].data()[i] += grouped_->baked.groups[g].weight * grouped_->groupIrradiance[g][p].data()[i];
    EXPECT_LT(errorOf(pagesOf(stateOf(grouped_->baked, {})), sum), 0.006) << "but for 7 bits of mantissa";
}

/// Of the brightest channel, at any weight.
TEST_F(LightGroupsBakeS33, DirectLightIsHeldToEightTenthsOfAPerCent)
{
    const BakedScene& baked = grouped_->baked;
    for (const char* name : {"sun", "west", "east", "day"}) {
        const std::size_t g = groupNamed(baked, name);
        const ImageRgb32f held = decodeRgb9e5(baked.groups[g].lightmaps[0], baked.groups[g].unitLux);
        const ImageRgb32f& truth = grouped_->groupIrradiance[g][0];
        float most = 0.0f;
        for (std::size_t i = 0; i < truth.texelCount(); ++i) {
            const vec3 light = truth.data()[i];
            const float brightest = std::max({light.x, light.y, light.z});
            if (!(brightest > 0.0f)) continue;
            const vec3 off = glm::abs(held.data()[i] - light) / brightest;
            most = std::max({most, off.x, off.y, off.z});
        }
        EXPECT_LT(most, 0.0105f) << name << ", with the rounding of nine bits before";
        EXPECT_GT(most, 0.002f) << name << " has fewer bits";
    }
}

/// West's strip lights the west room alone, though both rooms share its material.
TEST_F(LightGroupsBakeS33, RoomsThatShareAMaterialAreApart)
{
    const BakedScene& baked = grouped_->baked;
    const auto lightOf = [&](const char* name, float side) {
        const BakedGroup& group = baked.groups[groupNamed(baked, name)];
        double sum = 0.0;
        for (std::size_t i = 0; i < group.radiance.size(); ++i) {
            const vec3 place = baked.probes.probes[i].position;
            const bool inside = place.y > 0.3f && place.y < 2.3f && std::abs(place.z) < 1.7f;
            if (inside && place.x * side > 0.5f && place.x * side < 3.6f)
                sum += double(luminance(group.radiance[i][0]));
        }
        return sum;
    };
    EXPECT_GT(lightOf("west", -1), 0.0);
    EXPECT_LT(lightOf("west", 1), 0.01 * lightOf("west", -1));
    EXPECT_LT(lightOf("east", -1), 0.01 * lightOf("east", 1));
}

TEST_F(LightGroupsBakeS33, AChangedLightIsABakeOfTheChange)
{
    // The red lamp white and three times as bright, no sun, a dim sky.
    const BakedScene state = stateOf(grouped_->baked, {{"lamp", vec3(3.0f)}, {"sun", vec3(0)}, {"day", vec3(0.1f)}});
    Scene changed = rooms();
    for (Light& light : changed.lights) {
        if (light.name == "lamp") light.color = vec3(1.0f), light.intensity = 18.0f;
        if (light.name == "sun") light.intensity = 0.0f;
    }
    for (vec3* color : {&changed.sky.zenith, &changed.sky.horizon, &changed.sky.ground})
        *color *= 0.1f / grouped_->baked.groups[groupNamed(grouped_->baked, "day")].weight;
    BakeSettings off = settingsOf();
    off.groups = GroupChoice::Off;
    const BakeResult own = bakeOf(changed, off);
    EXPECT_NEAR(meanOf(pagesOf(state)) / meanOf(pagesOf(own.baked)), 1.0, 0.01);
    EXPECT_LT(errorOf(pagesOf(state), pagesOf(own.baked)), 0.08);
    for (std::size_t i = 0; i < changed.lights.size(); ++i) {
        const Light& light = state.scene.lights[i];
        const vec3 wanted = changed.lights[i].color * changed.lights[i].intensity;
        EXPECT_LE(glm::length(light.color * light.intensity - wanted), 1e-4f) << light.name;
        EXPECT_LE(glm::length(light.baking.atBake.colorIntensity - wanted), 1e-4f) << "nothing is stale";
    }
}

TEST_F(LightGroupsBakeS33, OffIsDark)
{
    const BakedScene dark = stateOf(grouped_->baked, kAllOff);
    const BakeResult candle = [] {
        Scene scene = rooms();
        for (Light& light : scene.lights)
            if (light.name != "candle") light.intensity = 0.0f;
        for (Material& material : scene.materials) material.emissiveNits = vec3(0.0f);
        scene.sky.zenith = scene.sky.horizon = scene.sky.ground = vec3(0.0f);
        BakeSettings off = settingsOf();
        off.groups = GroupChoice::Off;
        return bakeOf(scene, off);
    }();
    EXPECT_NEAR(meanOf(pagesOf(dark)) / meanOf(pagesOf(candle.baked)), 1.0, 0.02);
    EXPECT_LT(errorOf(pagesOf(dark), pagesOf(candle.baked)), 0.15);
    for (const Object& object : dark.scene.objects)
        for (const MeshPart& part : dark.scene.meshes[std::size_t(object.mesh)].parts)
            EXPECT_EQ(materialOf(dark.scene, part).emissiveNits, vec3(0.0f));
    EXPECT_EQ(dark.scene.sky.zenith, vec3(0.0f));
}

TEST_F(LightGroupsBakeS33, AFileKeepsGroups)
{
    const std::filesystem::path file = std::filesystem::temp_directory_path() / "halflight_light_groups_test.glb";
    WriteOptions write;
    write.groupIrradiance = grouped_->groupIrradiance;
    write.irradiance = grouped_->irradiance;
    ASSERT_TRUE(writeBakedScene(file, grouped_->baked, write));
    const Result<BakedScene> read = readBakedScene(file);
    ASSERT_TRUE(read) << read.error().text();
    ASSERT_EQ(read->groups.size(), grouped_->baked.groups.size());
    EXPECT_TRUE(read->lost.empty());
    for (const std::string& warning : read->scene.warnings)
        EXPECT_EQ(warning.find("stale"), std::string::npos) << warning;
    const std::vector<GroupWeight> change = {{"west", vec3(0)}, {"lamp", vec3(0, 1, 0)}};
    const BakedScene now = stateOf(grouped_->baked, change);
    const BakedScene later = stateOf(*read, change);
    EXPECT_LT(errorOf(pagesOf(later), pagesOf(now)), 0.01) << "the lamp's reflected light has 8 bits";
    for (const char* name : {"sun", "west", "east", "day"}) {
        const BakedGroup& before = grouped_->baked.groups[groupNamed(grouped_->baked, name)];
        const BakedGroup& after = read->groups[groupNamed(*read, name)];
        EXPECT_TRUE(before.direct) << name;
        ASSERT_EQ(after.lightmaps.size(), before.lightmaps.size());
        EXPECT_EQ(after.lightmaps[0].texels(), before.lightmaps[0].texels()) << name;
    }
    const BakedGroup& lamp = read->groups[groupNamed(*read, "lamp")];
    EXPECT_FALSE(lamp.direct) << "it is mixed";
    EXPECT_TRUE(lamp.directions.empty());
    for (std::size_t i = 0; i < now.probes.probes.size(); ++i)
        EXPECT_EQ(now.probes.probes[i].radiance[3], later.probes.probes[i].radiance[3]);
    // The strip of one room is off in the file of the state, that of the other is not.
    ASSERT_TRUE(writeBakedScene(file, later));
    const Result<BakedScene> state = readBakedScene(file);
    ASSERT_TRUE(state) << state.error().text();
    EXPECT_TRUE(state->groups.empty());
    int dark = 0;
    int lit = 0;
    for (const Object& object : state->scene.objects) {
        const Material& material = materialOf(state->scene, state->scene.meshes[std::size_t(object.mesh)].parts[0]);
        if (material.name != "neon") continue;
        (material.emissiveNits == vec3(0.0f) ? dark : lit) += 1;
    }
    EXPECT_EQ(dark, 1);
    EXPECT_EQ(lit, 1);
    std::filesystem::remove(file);
}

TEST(LightGroupsOfLampsS33, ALampThatIsOffCanBeSwitchedOn)
{
    Scene scene = rooms();
    for (Light& light : scene.lights)
        if (light.name == "lamp") light.intensity = 0.0f;
    const BakeResult result = bakeOf(scene, settingsOf());
    const BakedGroup& lamp = result.baked.groups[groupNamed(result.baked, "lamp")];
    EXPECT_EQ(lamp.weight, vec3(0.0f));
    EXPECT_GT(lamp.peakLux, 0.0f);
    const BakedScene on = stateOf(result.baked, {{"lamp", vec3(6.0f, 0.6f, 0.3f)}});
    BakeSettings off = settingsOf();
    off.groups = GroupChoice::Off;
    EXPECT_LT(errorOf(pagesOf(on), pagesOf(bakeOf(rooms(), off).baked)), 0.08);
}

TEST(LightGroupsOfLampsS33, WhatHasNoGroupsSaysSo)
{
    BakedScene none;
    const auto weights = groupWeights(none, {{"lamp", vec3(1)}});
    ASSERT_FALSE(weights);
    EXPECT_THAT(weights.error().text(), HasSubstr("has no light group \"lamp\""));
}

} // namespace
} // namespace halflight::test::bake_groups_test
