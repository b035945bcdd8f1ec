// S32. Irradiance pages that the application adds: result = law(lightmap) + dynamic, forward and deferred, in every
// mode that reads lightmaps.
#include "render/law_scene.h"

#include <cmath>

namespace halflight::test::dynamic_lightmaps_test {
namespace {

using namespace law;

class DynamicLightmapsS32 : public RenderTest, public testing::WithParamInterface<std::tuple<RunMode, RenderPath>> {
protected:
    RenderedFrame draw()
    {
        Result<RenderedFrame> frame = renderer->render(makeCamera(), settingsFor(mode(), std::get<1>(GetParam())));
        EXPECT_TRUE(frame) << frame.error().text();
        return std::move(*frame);
    }
    static RunMode mode() { return std::get<0>(GetParam()); }

    /// The floor by the law, written out by hand, with `dynamic` added to its lightmap after subtraction.
    void expectAdded(const LawScene& law, const RenderedFrame& frame, const std::function<vec3(int)>& dynamicOf)
    {
        expectSites(frame, [&](const Site& site) {
            const Light& sun = law.baked.scene.lights[0];
            const float realtime = realtimeOf(mode(), site.column);
            if (mode() == RunMode::Realtime)
                return directRadiance(site.point, sun, (1.0f - site.fade) * realtime + site.fade);
            const vec3 lightmap = lightmapOf(site.column);
            const vec3 dynamic = dynamicOf(site.column);
            if (mode() == RunMode::Subtractive)
                return indirectRadiance(site.point, subtractiveByHand(lightmap, vec3(kSunLux * kToSun.y), realtime,
                                                                      site.fade, kShadowColor, 1.0f) +
                                                        dynamic);
            const bool masked = mode() != RunMode::BakedIndirect;
            const float baked = inStaticShadow(site.column) ? kBakedShadow : 1.0f;
            const float attenuation = attenuationByHand(mode(), masked, baked, true, realtime, site.fade, 1.0f);
            return directRadiance(site.point, sun, attenuation) + indirectRadiance(site.point, lightmap + dynamic);
        });
    }
    /// A page whose columns of the floor have these values; the floor holds the middle half of the page.
    static ImageRgb32f page(int size, const std::function<vec3(int)>& dynamicOf)
    {
        ImageRgb32f result(size, size, vec3(1000.0f));
        for (int y = size / 4 - 1; y <= size * 3 / 4; ++y)
            for (int x = size / 4 - 1; x <= size * 3 / 4; ++x)
                result(x, y) = dynamicOf(glm::clamp((x - size / 4) / (size / 8), 0, 3));
        return result;
    }
    const vec3 kShadowColor{0.25f, 0.5f, 0.25f};
};

TEST_P(DynamicLightmapsS32, AreAddedAfterSubtractionAndMayChangeEachFrame)
{
    LawScene law = makeScene(bakeModeFor(mode()));
    law.baked.scene.subtractiveShadowColor = kShadowColor;
    ASSERT_TRUE(renderer->load(law.baked));
    const RenderedFrame without = draw();
    expectAdded(law, without, [](int) { return vec3(0.0f); });

    // Three sets one after another, the second of another size, the third far brighter than half floats.
    const std::function<vec3(int)> sets[] = {[](int column) { return vec3(0.5f, 0.25f * float(column), 2.0f); },
                                             [](int column) { return vec3(float(column), 1.0f, 0.0f); },
                                             [](int column) { return vec3(300000.0f, 1.0e5f * float(column), 8.0f); }};
    const int sizes[] = {128, 64, 64};
    for (int i = 0; i < 3; ++i) {
        const std::array pages{page(sizes[i], sets[i])};
        ASSERT_TRUE(renderer->setDynamicLightmaps(pages));
        expectAdded(law, draw(), sets[i]);
    }
    ASSERT_TRUE(renderer->setDynamicLightmaps({}));
    EXPECT_EQ(draw().radiance.texels(), without.radiance.texels()) << "taken away";
    const std::array again{page(64, sets[0])};
    ASSERT_TRUE(renderer->setDynamicLightmaps(again));
    ASSERT_TRUE(renderer->load(law.baked));
    EXPECT_EQ(draw().radiance.texels(), without.radiance.texels()) << "another scene begins without";
}
INSTANTIATE_TEST_SUITE_P(Modes, DynamicLightmapsS32,
                         testing::Combine(testing::Values(RunMode::Realtime, RunMode::BakedIndirect,
                                                          RunMode::Shadowmask, RunMode::DistanceShadowmask,
                                                          RunMode::Subtractive),
                                          kBothPaths));

class DynamicLightmapLimitsS32 : public RenderTest {};

TEST_F(DynamicLightmapLimitsS32, RefusesWhatCannotBe)
{
    const std::array good{ImageRgb32f(8, 8, vec3(1.0f))};
    EXPECT_FALSE(renderer->setDynamicLightmaps(good)) << "nothing loaded";
    const LawScene law = makeScene(MixedLightingMode::Shadowmask);
    ASSERT_TRUE(renderer->load(law.baked));
    EXPECT_TRUE(renderer->setDynamicLightmaps(good));
    const std::array two{good[0], good[0]};
    EXPECT_FALSE(renderer->setDynamicLightmaps(two)) << "one page more than the scene has";
    for (const float wrong : {-1.0f, NAN, INFINITY}) {
        std::array bad{good[0]};
        bad[0](3, 5).g = wrong;
        EXPECT_FALSE(renderer->setDynamicLightmaps(bad)) << wrong;
    }
    EXPECT_FALSE(renderer->setDynamicLightmaps(std::array{ImageRgb32f()}));
}

} // namespace
} // namespace halflight::test::dynamic_lightmaps_test
