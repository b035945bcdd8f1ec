// S36. More than four mixed lights at a point: channels of up to four mask layers, and whose shadow each holds.

#include "bake/lights/channels.h"
#include "bake/test_scene.h"

#include "halflight/bake/bake.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

namespace halflight::test::mask_layers_test {
namespace {

constexpr int kPage = 64;

/// Lamps in a ring above a floor; each one's shadow of the post in the middle falls to the other side.
Scene ring(int lamps)
{
    Scene scene;
    const int grey = addMaterial(scene, vec3(0.5f), vec3(0.0f), true);
    addRectangle(scene, {vec3(-4, 0, 4), vec3(8, 0, 0), vec3(0, 0, -8)}, grey, kPage, {vec2(1), vec2(63)});
    addRectangle(scene, {vec3(-0.4f, 0, 0), vec3(0.8f, 0, 0), vec3(0, 3, 0)}, grey, kPage);
    addRectangle(scene, {vec3(0, 0, -0.4f), vec3(0, 0, 0.8f), vec3(0, 3, 0)}, grey, kPage);
    for (int i = 0; i < lamps; ++i) {
        const float angle = (float(i) + 0.3f) * 2.0f * kPi / float(lamps);
        scene.lights.push_back(pointAt("lamp " + std::to_string(i),
                                       vec3(3.0f * std::cos(angle), 2.0f, 3.0f * std::sin(angle)), 30.0f,
                                       float(100 - i)));
    }
    return scene;
}

int bakedOf(const Scene& scene)
{
    int baked = 0;
    for (const Light& light : scene.lights) baked += light.baking.bakeType == LightMode::Baked ? 1 : 0;
    return baked;
}

TEST(LayersS36, SixteenLightsAtAPointHaveAChannelEach)
{
    for (const int lamps : {4, 5, 13, 16}) {
        Scene scene = ring(lamps);
        assignShadowmaskChannels(scene, MixedLightingMode::Shadowmask, kMostMaskLayers);
        std::set<int> channels;
        for (const Light& light : scene.lights) channels.insert(light.baking.occlusionMaskChannel);
        EXPECT_EQ(bakedOf(scene), 0);
        EXPECT_EQ(int(channels.size()), lamps);
        EXPECT_EQ(*channels.begin(), 0) << "the lowest free channels are taken";
        EXPECT_EQ(*channels.rbegin(), lamps - 1);
        EXPECT_EQ(maskLayersOf(scene), (lamps + 3) / 4);
    }
}

TEST(LayersS36, TheSeventeenthIsBakedAndNamed)
{
    Scene scene = ring(17);
    assignShadowmaskChannels(scene, MixedLightingMode::Shadowmask, kMostMaskLayers);
    EXPECT_EQ(bakedOf(scene), 1);
    const BakingOutput& last = scene.lights.back().baking;
    EXPECT_EQ(last.bakeType, LightMode::Baked);
    EXPECT_EQ(last.reason.find("overlaps sixteen other mixed lights"), 0u) << last.reason;
    EXPECT_EQ(last.reason.find("--mask-layers"), std::string::npos) << last.reason;
    // In one layer it says how to get more.
    scene = ring(5);
    assignShadowmaskChannels(scene, MixedLightingMode::Shadowmask, 1);
    EXPECT_EQ(bakedOf(scene), 1);
    EXPECT_NE(scene.lights.back().baking.reason.find("bake with --mask-layers auto"), std::string::npos);
}

/// 200 lamps along both sides of a street of 300 m, each in reach of twelve others.
TEST(LayersS36, AStreetOfTwoHundredLampsBakesNone)
{
    Scene scene;
    for (int i = 0; i < 200; ++i)
        scene.lights.push_back(
            pointAt("lamp " + std::to_string(i), vec3(3.0f * float(i / 2), 4, i % 2 == 0 ? -4.0f : 4.0f), 9.0f, 10.0f));
    assignShadowmaskChannels(scene, MixedLightingMode::Shadowmask, 1);
    EXPECT_GT(bakedOf(scene), 100) << "the test asks nothing of layers";
    assignShadowmaskChannels(scene, MixedLightingMode::Shadowmask, kMostMaskLayers);
    EXPECT_EQ(bakedOf(scene), 0);
    for (const Light& light : scene.lights) EXPECT_EQ(light.baking.reason, "") << light.name;
    for (std::size_t i = 0; i < scene.lights.size(); ++i)
        for (std::size_t j = i + 1; j < scene.lights.size(); ++j) {
            const Light& a = scene.lights[i];
            const Light& b = scene.lights[j];
            if (glm::distance(a.position(), b.position()) < 17.9f)
                EXPECT_NE(a.baking.occlusionMaskChannel, b.baking.occlusionMaskChannel) << a.name << ", " << b.name;
        }
}

/// Lights without a range keep all of their reach while layers suffice.
TEST(LayersS36, NoReachEndsWhileChannelsSuffice)
{
    Scene scene = ring(9);
    for (Light& light : scene.lights) light.rangeMeters = 0.0f;
    assignShadowmaskChannels(scene, MixedLightingMode::Shadowmask, kMostMaskLayers);
    EXPECT_EQ(bakedOf(scene), 0);
    for (const Light& light : scene.lights) EXPECT_EQ(light.baking.reachMeters, 0.0f);
}

/// Whether the post stands between a lamp and a place, by hand; -1 near the shadow's edge.
int isHidden(vec3 lamp, vec3 place)
{
    const auto crosses = [&](int axis, float margin) { // the rectangle of the post in the plane axis = 0
        const int other = 2 - axis;
        const float t = lamp[axis] / (lamp[axis] - place[axis]);
        if (!(t > 0.0f && t < 1.0f)) return false;
        const vec3 p = glm::mix(lamp, place, t);
        return std::abs(p[other]) < 0.4f + margin && p.y < 3.0f + margin;
    };
    constexpr float kMargin = 0.12f; // a texel is 13 cm wide
    const bool surely = crosses(0, -kMargin) || crosses(2, -kMargin);
    const bool perhaps = crosses(0, kMargin) || crosses(2, kMargin);
    return surely ? 1 : (perhaps ? -1 : 0);
}

TEST(LayersS36, EachChannelHoldsItsLightsShadow)
{
    Bench bench(ring(13), MixedLightingMode::Shadowmask, kPage, {}, kMostMaskLayers);
    ASSERT_EQ(maskLayersOf(bench.scene), 4);
    std::vector<std::vector<vec4>> masks;
    for (int layer = 0; layer < 4; ++layer) masks.push_back(bench.shadowmask(layer));
    int hidden = 0;
    for (std::size_t t = 0; t < bench.map.texels.size(); ++t) {
        const vec3 place = bench.positionOf(bench.map.texels[t]);
        if (place.y > 1.0e-3f || glm::length(place) < 0.8f) continue;
        for (const Light& light : bench.scene.lights) {
            const int channel = light.baking.occlusionMaskChannel;
            const int truth = isHidden(light.position(), place);
            if (truth < 0) continue;
            hidden += truth;
            EXPECT_EQ(masks[std::size_t(channel / 4)][t][channel % 4], truth == 1 ? 0.0f : 1.0f)
                << light.name << " at " << place.x << ' ' << place.z;
        }
        EXPECT_EQ(masks[3][t].y, 1.0f) << "channels without a light are lit";
    }
    EXPECT_GT(hidden, 1000);
}

TEST(LayersS36, ProbesHoldTheOcclusionOfAllLayers)
{
    Bench bench(ring(13), MixedLightingMode::Shadowmask, kPage, {}, kMostMaskLayers);
    const std::vector<vec3> places = {vec3(-2.0f, 0.5f, 0.3f), vec3(1.5f, 0.4f, 1.5f), vec3(0.2f, 0.3f, -2.5f)};
    std::vector<ProbeEstimate> probes(places.size());
    ASSERT_TRUE(bench.integrator->probes(places, allIndices(places.size()), 64, probes, {}));
    int hidden = 0;
    for (std::size_t p = 0; p < places.size(); ++p) {
        for (const Light& light : bench.scene.lights) {
            const int truth = isHidden(light.position(), places[p]);
            if (truth < 0) continue;
            hidden += truth;
            EXPECT_EQ(probes[p].occlusion[light.baking.occlusionMaskChannel], truth == 1 ? 0.0f : 1.0f) << light.name;
        }
        for (int channel = 13; channel < 16; ++channel) EXPECT_EQ(probes[p].occlusion[channel], 1.0f);
    }
    EXPECT_GE(hidden, 3);
}

BakeSettings quickSettings()
{
    BakeSettings settings;
    settings.samples = 16;
    settings.lightmapSize = kPage;
    settings.bounces = 1;
    settings.reflectionProbes = false;
    return settings;
}

/// A whole bake: a picture per page and layer; one that is lit everywhere is left out; the first four channels are
/// those of a bake in one layer.
TEST(LayersS36, ABakeHasAPictureForEachLayerInUse)
{
    Scene scene = ring(6);
    const Result<BakeResult> bake = halflight::bake(scene, quickSettings(), embreeIntegrators());
    ASSERT_TRUE(bake) << bake.error().text();
    const BakedScene& baked = bake->baked;
    EXPECT_EQ(baked.maskLayers, 2);
    ASSERT_EQ(baked.shadowmasks.size(), 2 * baked.lightmaps.size());
    for (const ImageRgba8& page : baked.shadowmasks) EXPECT_FALSE(page.empty());

    BakeSettings one = quickSettings();
    one.mostMaskLayers = 1;
    const Result<BakeResult> classic = halflight::bake(scene, one, embreeIntegrators());
    ASSERT_TRUE(classic) << classic.error().text();
    EXPECT_EQ(classic->baked.maskLayers, 1);
    EXPECT_EQ(bakedOf(classic->baked.scene), 2);
    ASSERT_EQ(classic->baked.shadowmasks.size(), classic->baked.lightmaps.size());

    // Lights that no caster hides from anything: their layer has no picture.
    Scene open = ring(4);
    for (const float x : {-1.0f, 1.0f}) {
        Light above = pointAt("above", vec3(30.0f + x, 2.0f, 0), 40.0f, 1.0f);
        above.rangeMeters = 60.0f;
        open.lights.push_back(above);
    }
    open.objects.resize(1); // the floor alone
    open.meshes.resize(1);
    const Result<BakeResult> lit = halflight::bake(open, quickSettings(), embreeIntegrators());
    ASSERT_TRUE(lit) << lit.error().text();
    EXPECT_EQ(lit->baked.maskLayers, 2);
    for (const ImageRgba8& page : lit->baked.shadowmasks) EXPECT_TRUE(page.empty());
}

} // namespace
} // namespace halflight::test::mask_layers_test
