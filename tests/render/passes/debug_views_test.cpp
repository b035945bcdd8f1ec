// S31. What every debug view says, to the value: the colours that docs/guide/pictures.md explains.
#include "halflight/shading/sh.h"
#include "render/law_scene.h"

#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/packing.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace halflight::test::debug_views_test {
namespace {

class DebugViewsS31 : public BothPaths {
protected:
    ImageRgba32f draw(const Camera& camera, RenderSettings settings, DebugView view)
    {
        settings.view = view;
        settings.path = GetParam();
        auto frame = renderer->render(camera, settings);
        if (!frame) {
            ADD_FAILURE() << frame.error().text();
            return ImageRgba32f(settings.size.x, settings.size.y);
        }
        plan = frame->plan;
        return std::move(frame->radiance);
    }
    FramePlan plan;
};
INSTANTIATE_TEST_SUITE_P(, DebugViewsS31, kBothPaths, pathNameOf);

// Fade is t in grey; shadowmask is R, G, B by channel, half as bright where A is in shadow; lightmap is the radiance of
// a white diffuse surface; overlap counts the lights with a channel.
TEST_P(DebugViewsS31, FadeMaskLightmapOverlap)
{
    using namespace law;
    LawScene scene = makeScene(MixedLightingMode::Shadowmask);
    for (u8vec4& texel : scene.baked.shadowmasks[0].texels())
        texel = texel.r == 51 ? u8vec4(51, 255, 102, 153) : u8vec4(255);
    ASSERT_TRUE(renderer->load(scene.baked));
    const RenderSettings settings = settingsFor(RunMode::Shadowmask);
    const ImageRgba32f fade = draw(makeCamera(), settings, DebugView::Fade);
    const ImageRgba32f mask = draw(makeCamera(), settings, DebugView::Shadowmask);
    const ImageRgba32f lightmap = draw(makeCamera(), settings, DebugView::Lightmap);
    const ImageRgba32f overlap = draw(makeCamera(), settings, DebugView::Overlap);
    for (const Site& site : sites()) {
        const ivec2 p = site.pixel;
        EXPECT_TRUE(near(vec3(fade(p.x, p.y)), vec3(site.fade), 1.0e-3f, 2.0e-4f));
        const vec3 expected = inStaticShadow(site.column) ? vec3(0.2f, 1.0f, 0.4f) * (0.5f + 0.5f * 0.6f) : vec3(1.0f);
        EXPECT_TRUE(near(vec3(mask(p.x, p.y)), expected));
        EXPECT_TRUE(near(vec3(lightmap(p.x, p.y)), lightmapOf(site.column) / kPi));
        EXPECT_TRUE(near(vec3(overlap(p.x, p.y)), vec3(0, 0, 1)));
    }
    EXPECT_EQ(vec3(fade(0, 0)), vec3(0.0f)) << "above the horizon there is nothing to show";
}

// A dynamic object has no lightmap and shows its probe: occlusion by channel in the mask's view, radiance by direction
// in the probes' view, which lightmapped objects show too.
TEST_P(DebugViewsS31, ProbesOnBothKindsOfObject)
{
    using namespace law;
    for (const bool isStatic : {true, false}) {
        LawScene scene = makeScene(MixedLightingMode::Shadowmask);
        scene.baked.scene.objects[std::size_t(scene.floor)].isStatic = isStatic;
        Probe probe;
        probe.radiance = {vec3(2.0f, 1.5f, 1.0f),
                          vec3(0.3f, 0.1f, -0.2f),
                          vec3(0.1f),
                          vec3(0.2f),
                          vec3(0.05f),
                          vec3(0.0f),
                          vec3(0.1f),
                          vec3(0.02f),
                          vec3(-0.1f)};
        probe.occlusion.layers[0] = vec4(0.9f, 0.5f, 0.25f, 0.75f);
        scene.baked.probes.probes = {probe};
        ASSERT_TRUE(renderer->load(scene.baked));
        const RenderSettings settings = settingsFor(RunMode::Shadowmask);
        const ImageRgba32f probes = draw(makeCamera(), settings, DebugView::Probes);
        const ImageRgba32f mask = draw(makeCamera(), settings, DebugView::Shadowmask);
        const ImageRgba32f lightmap = draw(makeCamera(), settings, DebugView::Lightmap);
        vec3 irradiance(0.0f); // on a surface that faces up
        for (int i = 0; i < 9; ++i)
            irradiance += probe.radiance[std::size_t(i)] * shading::shIrradianceWeight(i, vec3(0, 1, 0));
        for (const Site& site : sites()) {
            const ivec2 p = site.pixel;
            EXPECT_TRUE(near(vec3(probes(p.x, p.y)), irradiance / kPi));
            if (isStatic) continue;
            EXPECT_TRUE(near(vec3(mask(p.x, p.y)), vec3(0.9f, 0.5f, 0.25f) * (0.5f + 0.5f * 0.75f)));
            EXPECT_EQ(vec3(lightmap(p.x, p.y)), vec3(0.0f));
        }
    }
}

// Cascades are red, green, blue, yellow from near to far, mixed where they blend, paler with the fade, darker at
// grazing angles.
TEST_P(DebugViewsS31, Cascades)
{
    using namespace law;
    const LawScene scene = makeScene(MixedLightingMode::Shadowmask);
    ASSERT_TRUE(renderer->load(scene.baked));
    const std::array<vec3, 4> colors{vec3(1, 0.3f, 0.3f), vec3(0.3f, 1, 0.3f), vec3(0.3f, 0.4f, 1), vec3(1, 1, 0.3f)};
    for (int cascades = 1; cascades <= 4; ++cascades) {
        RenderSettings settings = settingsFor(RunMode::Shadowmask);
        settings.shadows.cascades = cascades;
        settings.shadows.cascadeSplitLambda = 0.1f; // wide bands at the sites' distances
        const ImageRgba32f view = draw(makeCamera(), settings, DebugView::Cascades);
        std::array<int, 4> seen{};
        for (const Site& site : sites()) {
            const float distance = glm::distance(vec3(0, 4, 0), site.point.position);
            int cascade = 0;
            while (cascade + 1 < cascades && distance > plan.cascadeFar[std::size_t(cascade)]) ++cascade;
            const float end = plan.cascadeFar[std::size_t(cascade)];
            const float weight =
                cascade + 1 < cascades
                    ? glm::clamp((distance - end) / (settings.shadows.cascadeBlendFraction * end) + 1.0f, 0.0f, 1.0f)
                    : 0.0f;
            const vec3 color =
                glm::mix(colors[std::size_t(cascade)], colors[std::size_t(std::min(cascade + 1, 3))], weight);
            const vec3 expected = glm::mix(color, vec3(1.0f), site.fade) * (0.25f + 0.75f * site.point.view.y);
            EXPECT_TRUE(near(vec3(view(site.pixel.x, site.pixel.y)), expected, 5.0e-3f, 1.0e-3f))
                << cascades << " cascades, distance " << distance;
            ++seen[std::size_t(cascade)];
        }
        EXPECT_GT(seen[std::size_t(cascades - 1)], 0);
    }
}

// Lights that reach the point with a channel, or that overflowed: black, blue, green, yellow, red, and white from five
// on. Other lights without a channel do not count.
TEST_P(DebugViewsS31, OverlapCountsMaskedLights)
{
    BakedScene baked;
    baked.isBaked = true;
    Scene& scene = baked.scene;
    addObject(scene, makeRectangle(30, 4, addMaterial(scene, vec4(0.5f, 0.5f, 0.5f, 1.0f))), mat4(1.0f), true);
    scene.objects[0].lightmap = {0, vec2(1.0f), vec2(0.0f)};
    baked.lightmaps.emplace_back(8, 8, glm::packF3x9_E1x5(vec3(1.0f)));
    baked.shadowmasks.emplace_back(8, 8, u8vec4(255));
    // Strip n (4 m wide in x) is reached by lights 0 … n - 1: light n's range ends where strip n does.
    for (int i = 0; i < 6; ++i) {
        Light light;
        light.type = LightType::Point;
        light.worldFromLight = lightPose(vec3(14, 0.5f, 0), vec3(0, -1, 0));
        light.intensity = 10.0f;
        light.rangeMeters = 26.0f - 4.0f * float(i);
        bakeAsMixed(light, MixedLightingMode::Shadowmask, i % 4);
        scene.lights.push_back(light);
    }
    Light unmasked = scene.lights[0];
    unmasked.baking.occlusionMaskChannel = -1;
    scene.lights.push_back(unmasked);
    unmasked.mode = unmasked.baking.bakeType = LightMode::Baked; // as its author wished
    scene.lights.push_back(unmasked);
    for (const std::size_t overflowed : {2, 5}) { // S10: mixed, and no channel was left
        scene.lights[overflowed].baking.bakeType = LightMode::Baked;
        scene.lights[overflowed].baking.occlusionMaskChannel = -1;
    }
    ASSERT_TRUE(renderer->load(baked));
    const Camera camera = lookAt(vec3(0, 20, 0.01f), vec3(0.0f), 1.2f);
    RenderSettings settings;
    settings.mode = RunMode::Shadowmask;
    settings.size = {320, 60};
    const ImageRgba32f view = draw(camera, settings, DebugView::Overlap);
    const std::array<vec3, 6> ramp{vec3(0), vec3(0, 0, 1), vec3(0, 1, 0), vec3(1, 1, 0), vec3(1, 0, 0), vec3(1)};
    for (int count = 0; count <= 6; ++count) {
        const float x = std::clamp(14.0f - 26.0f + 4.0f * float(count) - 2.0f, -14.5f, 14.0f);
        const ivec2 pixel = pixelOf(camera, settings.size, vec3(x, 0, 0));
        EXPECT_EQ(vec3(view(pixel.x, pixel.y)), ramp[std::size_t(std::min(count, 5))]) << count << " at x " << x;
    }
}

// 4 texels a metre are cyan, 16 green, in squares of two brightnesses.
TEST_P(DebugViewsS31, TexelsPerMeter)
{
    for (const auto& [pageTexels, color] : {std::pair(32, vec3(0, 1, 1)), std::pair(128, vec3(0, 1, 0))}) {
        BakedScene baked;
        baked.isBaked = true;
        Scene& scene = baked.scene;
        addObject(scene, makeRectangle(8, 8, addMaterial(scene, vec4(0.5f, 0.5f, 0.5f, 1.0f))), mat4(1.0f), true);
        scene.objects[0].lightmap = {0, vec2(1.0f), vec2(0.0f)};
        baked.lightmaps.emplace_back(pageTexels, pageTexels, glm::packF3x9_E1x5(vec3(1.0f)));
        ASSERT_TRUE(renderer->load(baked));
        const Camera camera = lookAt(vec3(0, 2, 0.001f), vec3(0.0f), 1.2f);
        RenderSettings settings;
        settings.mode = RunMode::BakedIndirect;
        settings.size = {200, 200};
        const ImageRgba32f view = draw(camera, settings, DebugView::Texels);
        const float texelMeters = 8.0f / float(pageTexels);
        const auto at = [&](float texelsRight) {
            const ivec2 p =
                pixelOf(camera, settings.size, vec3((texelsRight + 0.5f) * texelMeters, 0, 0.5f * texelMeters));
            return vec3(view(p.x, p.y));
        };
        const float brightness = at(0).g;
        EXPECT_LT(std::abs(std::abs(brightness - 0.75f) - 0.25f), 0.01f) << brightness << ": 1 or a half";
        EXPECT_TRUE(near(at(0), brightness * color, 0.02f, 0.02f));
        EXPECT_TRUE(near(at(1), (1.5f - brightness) * color, 0.02f, 0.02f));
        EXPECT_TRUE(near(at(2), brightness * color, 0.02f, 0.02f));
    }
}

} // namespace
} // namespace halflight::test::debug_views_test
