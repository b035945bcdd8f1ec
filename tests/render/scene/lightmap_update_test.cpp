// Rectangles of lightmap pages that change while a scene is drawn, as bakes in the background do it.
#include "render/render_test.h"

#include "halflight/base/rgb9e5.h"

#include <glm/gtc/matrix_transform.hpp>

#include <array>

namespace halflight::test::lightmap_update_test {
namespace {

BakedScene twoPages()
{
    BakedScene baked;
    baked.isBaked = true;
    baked.mode = MixedLightingMode::BakedIndirect;
    Scene& scene = baked.scene;
    const int grey = addMaterial(scene, vec4(0.5f, 0.5f, 0.5f, 1.0f));
    for (int i = 0; i < 2; ++i) {
        addObject(scene, makeRectangle(2, 4, grey), glm::translate(mat4(1.0f), vec3(2.0f * float(i) - 1.0f, 0, 0)),
                  true);
        scene.objects[std::size_t(i)].lightmap = {i, vec2(1.0f), vec2(0.0f)};
        baked.lightmaps.emplace_back(64, 64, packRgb9e5(vec3(1.0f + float(i), 2.0f, 3.0f)));
    }
    return baked;
}

class LightmapUpdate : public RenderTest {
protected:
    ImageRgba32f draw()
    {
        RenderSettings settings;
        settings.mode = RunMode::BakedIndirect;
        settings.size = {96, 96};
        Result<RenderedFrame> frame = renderer->render(lookAt(vec3(0, 4, 0.001f), vec3(0)), settings);
        EXPECT_TRUE(frame) << frame.error().text();
        return std::move(frame->radiance);
    }
};

TEST_F(LightmapUpdate, DrawsAsIfLoadedAnew)
{
    BakedScene baked = twoPages();
    ASSERT_TRUE(renderer->load(baked));
    const ImageRgba32f before = draw();
    const Image<uint32_t> first(20, 30, packRgb9e5(vec3(7.0f, 0.5f, 0.0f)));
    const Image<uint32_t> second(64, 5, packRgb9e5(vec3(0.0f, 0.0f, 9.0f)));
    const std::array<LightmapRectangle, 2> rectangles{{{0, {10, 3}, &first}, {1, {0, 59}, &second}}};
    ASSERT_TRUE(renderer->updateLightmaps(rectangles));
    const ImageRgba32f updated = draw();
    for (const LightmapRectangle& r : rectangles)
        for (int y = 0; y < r.texels->height(); ++y)
            for (int x = 0; x < r.texels->width(); ++x)
                baked.lightmaps[std::size_t(r.page)](r.offset.x + x, r.offset.y + y) = (*r.texels)(x, y);
    ASSERT_TRUE(renderer->load(baked));
    const ImageRgba32f loaded = draw();
    EXPECT_EQ(updated.texels(), loaded.texels());
    EXPECT_GT(compare(before, updated).differing, 500);
}

TEST_F(LightmapUpdate, RefusesWhatIsNotOnAPage)
{
    startAnew();
    const Image<uint32_t> texels(8, 8);
    LightmapRectangle rectangle{0, {0, 0}, &texels};
    EXPECT_FALSE(renderer->updateLightmaps({&rectangle, 1})) << "nothing is loaded";
    ASSERT_TRUE(renderer->load(twoPages()));
    const ImageRgba32f before = draw();
    for (const LightmapRectangle& bad :
         {LightmapRectangle{2, {0, 0}, &texels}, LightmapRectangle{-1, {0, 0}, &texels},
          LightmapRectangle{0, {57, 0}, &texels}, LightmapRectangle{0, {0, -1}, &texels}}) {
        const std::array<LightmapRectangle, 2> both{rectangle, bad};
        EXPECT_FALSE(renderer->updateLightmaps(both));
    }
    EXPECT_EQ(draw().texels(), before.texels());
    EXPECT_TRUE(renderer->updateLightmaps({}));
}

} // namespace
} // namespace halflight::test::lightmap_update_test
