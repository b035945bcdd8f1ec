// The order of a bake in the background: every texel once, what a camera sees first.
#include "bake/geometry/flatten.h"
#include "bake/live/live_pages.h"
#include "bake/test_room.h"
#include "bake/texels/rasterize.h"
#include "bake/texels/texel_order.h"
#include "bake/texels/texel_places.h"

#include "halflight/base/rgb9e5.h"

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

namespace halflight::test::texel_order_test {
namespace {

struct Room {
    Room()
    {
        UnwrapSettings settings;
        settings.pageSize = 256;
        Result<UnwrappedScene> unwrapped = unwrap(room(true, true, true), settings);
        scene = std::move(unwrapped->scene);
        geometry = flattenGeometry(scene, unwrapped->pageSize, GeometryFilter::Static);
        map = rasterizeTexels(geometry, unwrapped->pageSize, unwrapped->pageCount);
    }
    Scene scene;
    BakeGeometry geometry;
    TexelMap map;
};

std::vector<uint32_t> takeAll(TexelOrder& order, const std::optional<BakeView>& view, std::size_t atOnce)
{
    std::vector<uint32_t> texels;
    for (auto pieces = order.next(view, atOnce); !pieces.empty(); pieces = order.next(view, atOnce))
        for (const std::size_t piece : pieces)
            texels.insert(texels.end(), order.texelsOf(piece).begin(), order.texelsOf(piece).end());
    return texels;
}

TEST(TexelOrder, HasEveryTexelOnce)
{
    const Room room;
    BakeView view;
    view.camera.worldFromCamera = glm::inverse(glm::lookAt(vec3(0.5f, 1, 0.5f), vec3(2, 0, 1), vec3(0, 1, 0)));
    for (const bool charts : {false, true}) {
        for (const std::optional<BakeView>& from : {std::optional<BakeView>(), std::optional(view)}) {
            TexelOrder order = charts ? TexelOrder::ofCharts(room.geometry, room.map)
                                      : TexelOrder::ofRuns(room.geometry, room.map, 1000);
            std::vector<uint32_t> texels = takeAll(order, from, 3000);
            std::sort(texels.begin(), texels.end());
            ASSERT_EQ(texels.size(), room.map.texels.size());
            for (uint32_t i = 0; i < texels.size(); ++i) ASSERT_EQ(texels[i], i);
        }
    }
}

TEST(TexelOrder, PiecesOfChartsHaveOneChartEach)
{
    const Room room;
    TexelOrder order = TexelOrder::ofCharts(room.geometry, room.map);
    for (auto pieces = order.next(std::nullopt, 1); !pieces.empty(); pieces = order.next(std::nullopt, 1)) {
        ASSERT_EQ(pieces.size(), 1u);
        const auto texels = order.texelsOf(pieces[0]);
        EXPECT_TRUE(std::is_sorted(texels.begin(), texels.end()));
        for (const uint32_t texel : texels) ASSERT_EQ(room.map.texels[texel].chart, room.map.texels[texels[0]].chart);
    }
}

/// Squares before the camera that face it, the nearest first, then one that faces away, then one behind it.
TEST(TexelOrder, BeginsWithWhatTheCameraSees)
{
    constexpr int kPage = 64;
    Scene scene;
    const int white = addMaterial(scene, vec3(0.7f));
    addRectangle(scene, {vec3(-1, -1, 2), vec3(0, 2, 0), vec3(2, 0, 0)}, white, kPage, {vec2(1), vec2(21)});
    addRectangle(scene, {vec3(-1, -1, -4), vec3(0, 2, 0), vec3(2, 0, 0)}, white, kPage, {vec2(24, 1), vec2(44, 21)});
    addRectangle(scene, {vec3(-1, 1, -6), vec3(2, 0, 0), vec3(0, 2, 0)}, white, kPage, {vec2(1, 24), vec2(21, 44)});
    addRectangle(scene, {vec3(-1, -1, -3), vec3(2, 0, 0), vec3(0, 2, 0)}, white, kPage, {vec2(24, 24), vec2(44, 44)});
    const BakeGeometry geometry = flattenGeometry(scene, kPage, GeometryFilter::Static);
    const TexelMap map = rasterizeTexels(geometry, kPage, 1);
    BakeView view; // from the origin along -Z
    for (const bool orthographic : {false, true}) {
        view.camera.orthographic = orthographic;
        view.camera.orthographicHeightMeters = 6.0f;
        TexelOrder order = TexelOrder::ofCharts(geometry, map);
        for (const float z : {-3.0f, -6.0f, -4.0f, 2.0f}) {
            const std::vector<std::size_t> pieces = order.next(view, 1);
            ASSERT_EQ(pieces.size(), 1u);
            const uint32_t texel = order.texelsOf(pieces[0])[0];
            EXPECT_NEAR(placeOf(geometry, map, map.texels[texel]).position.z, z, 1.0e-4f);
        }
    }
}

/// One light everywhere is spread to every texel of the pages, and to the padding around charts.
TEST(LivePages, SpreadSamplesReachEveryTexel)
{
    const Room room;
    const int side = 8;
    const std::vector<uint32_t> samples = sampleTexels(room.map, side);
    EXPECT_LT(samples.size() * 16, room.map.texels.size());
    LivePages pages(room.map);
    pages.spread(samples, std::vector<vec3>(samples.size(), vec3(3, 2, 1)), side);
    EXPECT_NEAR(pages.brightest(), 3.0f, 1.0e-4f);
    const std::vector<Image<uint32_t>> all = pages.takeAll(1.0f);
    for (std::size_t p = 0; p < all.size(); ++p) {
        const ImageRgb32f page = decodeRgb9e5(all[p]);
        for (const Texel& texel : room.map.texels)
            if (texel.page == p) ASSERT_LT(glm::distance(page(texel.x, texel.y), vec3(3, 2, 1)), 0.02f);
    }
    std::size_t lit = 0;
    for (const Image<uint32_t>& page : all)
        lit +=
            std::size_t(std::count_if(page.texels().begin(), page.texels().end(), [](uint32_t t) { return t != 0; }));
    EXPECT_GT(lit, room.map.texels.size()) << "padding too";
    EXPECT_TRUE(pages.takeChanged(1.0f).empty());
}

TEST(LivePages, TilesHoldWhatChanged)
{
    const Room room;
    LivePages pages(room.map);
    (void)pages.takeAll(1.0f);
    const uint32_t texel = uint32_t(room.map.texels.size() / 2);
    pages.set(texel, vec3(1.0f, 0.5f, 0.25f));
    const std::vector<LightTile> tiles = pages.takeChanged(1.0f);
    ASSERT_EQ(tiles.size(), 1u);
    const Texel& at = room.map.texels[texel];
    EXPECT_EQ(tiles[0].page, int(at.page));
    const ivec2 place = ivec2(at.x, at.y) - tiles[0].offset;
    EXPECT_EQ(tiles[0].texels(place.x, place.y), packRgb9e5(vec3(1.0f, 0.5f, 0.25f)));
    EXPECT_TRUE(pages.takeChanged(1.0f).empty()) << "once";
}

} // namespace
} // namespace halflight::test::texel_order_test
