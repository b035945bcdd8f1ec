// From values of texels to pages: filling, dilation, encoding, distance fields (spec S6, S8).

#include "bake/geometry/flatten.h"
#include "bake/pages/dilate.h"
#include "bake/pages/encode.h"
#include "bake/pages/mask_field.h"
#include "bake/test_scene.h"
#include "bake/texels/rasterize.h"

#include "halflight/base/rgb9e5.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace halflight::test::pages_test {
namespace {

constexpr int kPage = 64;

/// Two charts three texels apart: each grows two rings of its own value, and none of the other's.
TEST(DilateS6, NeverCrossesCharts)
{
    Scene scene;
    const int grey = addMaterial(scene, vec3(0.5f));
    addRectangle(scene, {}, grey, kPage, {vec2(4), vec2(12)});
    addRectangle(scene, {vec3(5, 0, 0)}, grey, kPage, {vec2(15, 4), vec2(23, 12)});
    const BakeGeometry geometry = flattenGeometry(scene, kPage, GeometryFilter::Static);
    const TexelMap map = rasterizeTexels(geometry, kPage, 1);
    ASSERT_EQ(map.chartCount, 2u);
    std::vector<vec3> values(map.texels.size());
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = map.texels[i].x < 13 ? vec3(1, 0, 0) : vec3(0, 1, 0);
    const Image<vec3> page = dilate(map, values, 2)[0];
    for (int y = 4; y < 12; ++y) {
        EXPECT_EQ(page(12, y), vec3(1, 0, 0));
        EXPECT_EQ(page(14, y), vec3(0, 1, 0));
        EXPECT_TRUE(page(13, y) == vec3(1, 0, 0) || page(13, y) == vec3(0, 1, 0));
        EXPECT_EQ(page(2, y), vec3(1, 0, 0));
        EXPECT_EQ(page(1, y), vec3(0));
    }
}

TEST(DilateS6, InvalidTexelsTakeTheirOwnChartsValues)
{
    Scene scene;
    const int grey = addMaterial(scene, vec3(0.5f));
    addRectangle(scene, {}, grey, kPage, {vec2(4), vec2(12)});
    addRectangle(scene, {vec3(5, 0, 0)}, grey, kPage, {vec2(12, 4), vec2(20, 12)});
    const BakeGeometry geometry = flattenGeometry(scene, kPage, GeometryFilter::Static);
    const TexelMap map = rasterizeTexels(geometry, kPage, 1);
    std::vector<vec3> values(map.texels.size());
    std::vector<uint8_t> valid(map.texels.size(), 1);
    for (std::size_t i = 0; i < values.size(); ++i) {
        values[i] = map.texels[i].x < 12 ? vec3(1, 0, 0) : vec3(0, 1, 0);
        if (map.texels[i].x >= 9 && map.texels[i].x < 12) {
            values[i] = vec3(0);
            valid[i] = 0;
        }
    }
    fillInvalid(geometry, map, valid, values);
    for (std::size_t i = 0; i < values.size(); ++i)
        EXPECT_EQ(values[i], map.texels[i].x < 12 ? vec3(1, 0, 0) : vec3(0, 1, 0));
}

/// A chart without a valid texel takes the light of what lies beside it in the world and faces the same way.
TEST(DilateS6, ChartsInsideGeometryTakeTheirSurroundingsValues)
{
    Scene scene;
    const int grey = addMaterial(scene, vec3(0.5f));
    addRectangle(scene, {}, grey, kPage, {vec2(4), vec2(20)});
    addRectangle(scene, {vec3(1, 0, 0), vec3(0.05f, 0, 0), vec3(0, 0, -1)}, grey, kPage, {vec2(40, 4), vec2(41, 20)});
    addRectangle(scene, {vec3(1, -0.1f, -1), vec3(0, 0, 1), vec3(0, -1, 0)}, grey, kPage, {vec2(30, 30), vec2(46, 46)});
    const BakeGeometry geometry = flattenGeometry(scene, kPage, GeometryFilter::Static);
    const TexelMap map = rasterizeTexels(geometry, kPage, 1);
    std::vector<vec3> values(map.texels.size());
    std::vector<uint8_t> valid(map.texels.size(), 1);
    for (std::size_t i = 0; i < values.size(); ++i) {
        const bool sliver = map.texels[i].x >= 39 && map.texels[i].y < 22;
        values[i] = sliver ? vec3(0) : map.texels[i].x < 22 ? vec3(1, 0, 0) : vec3(0, 1, 0);
        valid[i] = sliver ? 0 : 1;
    }
    fillInvalid(geometry, map, valid, values);
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (!valid[i]) EXPECT_LT(glm::distance(values[i], vec3(1, 0, 0)), 1e-4f);
    }
}

TEST(EncodeS6, Rgb9e5KeepsColoursWithinItsPrecision)
{
    std::mt19937 random(5);
    std::uniform_real_distribution<float> exponent(-8.0f, 15.99f);
    ImageRgb32f page(64, 64);
    for (vec3& texel : page.texels()) {
        texel = vec3(std::exp2(exponent(random)), std::exp2(exponent(random)), std::exp2(exponent(random)));
    }
    page(0, 0) = vec3(0);
    page(1, 0) = vec3(-1, 2, 3);
    const ImageRgb32f decoded = decodeRgb9e5(encodeLightmap({page}, 1.0f)[0], 1.0f);
    EXPECT_EQ(decoded(0, 0), vec3(0));
    EXPECT_EQ(decoded(1, 0).x, 0.0f);
    ImageRgb32f extreme(2, 1, vec3(1e9f, 65408.0f, std::nanf("")));
    EXPECT_EQ(decodeRgb9e5(encodeLightmap({extreme}, 1.0f)[0], 1.0f)(0, 0), vec3(65408.0f, 65408.0f, 0.0f));
    for (std::size_t i = 2; i < page.texelCount(); ++i) {
        const vec3 a = page.data()[i];
        const float step = std::max({a.x, a.y, a.z}) / 256.0f;
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(decoded.data()[i][c], a[c], 0.51f * step);
    }
}

/// What is brighter than the format holds gets a larger unit, a power of two, so that nothing is cut and nothing loses
/// a bit; what is not keeps 1.
TEST(EncodeS6, DaylightIsNotCut)
{
    EXPECT_EQ(lightmapUnitFor({ImageRgb32f(2, 2, vec3(65408.0f))}), 1.0f);
    EXPECT_EQ(lightmapUnitFor({}), 1.0f);
    ImageRgb32f bright(3, 1, vec3(120000.0f, 100000.0f, 0.25f));
    bright(1, 0) = vec3(300000.0f);
    bright(2, 0) = vec3(kInfinity);
    const float unit = lightmapUnitFor({bright});
    EXPECT_EQ(unit, 8.0f);
    const ImageRgb32f decoded = decodeRgb9e5(encodeLightmap({bright}, unit)[0], unit);
    EXPECT_NEAR(decoded(0, 0).x, 120000.0f, 120000.0f / 512.0f);
    EXPECT_NEAR(decoded(0, 0).y, 100000.0f, 120000.0f / 512.0f);
    EXPECT_NEAR(decoded(1, 0).x, 300000.0f, 300000.0f / 512.0f);
    for (const float value : {3.0f, 0.01f, 12345.0f}) {
        const ImageRgb32f page(1, 1, vec3(value));
        EXPECT_EQ(decodeRgb9e5(encodeLightmap({page}, 4.0f)[0], 4.0f)(0, 0),
                  decodeRgb9e5(encodeLightmap({page}, 1.0f)[0], 1.0f)(0, 0));
    }
}

/// Texels' exact shares of light beside a straight edge become distances that are right to a tenth of a texel, at any
/// angle; a wide penumbra stays attenuation.
TEST(MaskFieldS8, HardEdgesBecomeDistancesAndSoftOnesStay)
{
    Scene scene;
    addRectangle(scene, {}, addMaterial(scene, vec3(0.5f)), kPage, {vec2(0), vec2(64)});
    const BakeGeometry geometry = flattenGeometry(scene, kPage, GeometryFilter::Static);
    const TexelMap map = rasterizeTexels(geometry, kPage, 1);
    for (const float degrees : {0.0f, 7.0f, 31.0f, 45.0f, 80.0f, 200.0f}) {
        const vec2 n(std::cos(glm::radians(degrees)), std::sin(glm::radians(degrees)));
        const auto distanceAt = [&](vec2 p) { return glm::dot(p - vec2(32.3f, 31.8f), n); };
        std::vector<vec4> mask(map.texels.size(), vec4(1.0f));
        for (std::size_t i = 0; i < mask.size(); ++i) {
            const vec2 corner(map.texels[i].x, map.texels[i].y);
            mask[i].x = 0.0f;
            for (int s = 0; s < 1024; ++s) {
                const vec2 p = corner + (vec2(s % 32, s / 32) + 0.5f) / 32.0f;
                if (distanceAt(p) > 0.0f) mask[i].x += 1.0f / 1024.0f;
            }
            mask[i].y = glm::clamp(0.5f + distanceAt(corner + 0.5f) / 12.0f, 0.0f, 1.0f);
        }
        const std::vector<vec4> before = mask;
        const auto channels = maskToDistances(map, mask);
        ASSERT_GT(channels[0].rangeTexels, 0.0f);
        EXPECT_LT(channels[0].penumbraTexels, 0.2f);
        EXPECT_EQ(channels[1].rangeTexels, 0.0f);
        EXPECT_EQ(channels[2].rangeTexels, 0.0f);
        for (std::size_t i = 0; i < mask.size(); ++i) {
            EXPECT_EQ(vec3(mask[i].y, mask[i].z, mask[i].w), vec3(before[i].y, before[i].z, before[i].w));
            const Texel& t = map.texels[i];
            if (std::min({t.x, t.y}) < 6 || std::max({t.x, t.y}) > 57) continue; // the edge goes on beyond the chart
            const float range = channels[0].rangeTexels;
            const float truth = glm::clamp(distanceAt(vec2(t.x, t.y) + 0.5f), -range, range);
            EXPECT_NEAR((2.0f * mask[i].x - 1.0f) * range, truth, 0.1f) << degrees << "° at " << t.x << ' ' << t.y;
        }
    }
}

/// Distances go on straight into the padding, so that edges do not bend at a chart's border.
TEST(DilateS8, DistancesAreExtrapolated)
{
    Scene scene;
    addRectangle(scene, {}, addMaterial(scene, vec3(0.5f)), kPage, {vec2(10), vec2(30)});
    const BakeGeometry geometry = flattenGeometry(scene, kPage, GeometryFilter::Static);
    const TexelMap map = rasterizeTexels(geometry, kPage, 1);
    std::vector<vec4> values;
    const auto plane = [](int x, int y) { return 0.5f + 0.03f * float(x - 20) - 0.02f * float(y - 20); };
    for (const Texel& t : map.texels) values.emplace_back(plane(t.x, t.y));
    const Image<vec4> page = dilate(map, values, 2, true)[0];
    for (int y = 11; y < 29; ++y) {
        for (const int x : {8, 9, 30, 31}) EXPECT_NEAR(page(x, y).x, plane(x, y), 1e-4f) << x << ' ' << y;
    }
}

} // namespace
} // namespace halflight::test::pages_test
