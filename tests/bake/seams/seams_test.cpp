// Where charts meet, filtered light agrees on both sides (spec S6).

#include "bake/geometry/flatten.h"
#include "bake/pages/dilate.h"
#include "bake/seams/seam_parts.h"
#include "bake/seams/seams.h"
#include "bake/test_scene.h"
#include "bake/texels/rasterize.h"
#include "halflight/base/image_filter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace halflight::test::seams_test {
namespace {

constexpr int kPage = 64;

/// A plane cut into two charts, of a given width in texels, each of which holds light of its own: lightAt(left, texels
/// up from the foot of the cut).
struct CutPlane {
    static constexpr vec2 kLeft{4.3f, 4.6f};
    static constexpr vec2 kRight{30.8f, 30.1f};
    template<typename LightAt> CutPlane(float texels, const LightAt& lightAt)
    {
        const int grey = addMaterial(scene, vec3(0.5f));
        const vec2 size(texels, 16.0f);
        const vec3 across(texels / 16.0f, 0, 0);
        addRectangle(scene, {vec3(0, 0, 0), across, vec3(0, 0, -1)}, grey, kPage, {kLeft, kLeft + size});
        addRectangle(scene, {across, across, vec3(0, 0, -1)}, grey, kPage, {kRight, kRight + size});
        const BakeGeometry geometry = flattenGeometry(scene, kPage, GeometryFilter::Static);
        map = rasterizeTexels(geometry, kPage, 1);
        std::vector<vec3> values;
        for (const Texel& t : map.texels) {
            const bool left = t.x < 25;
            values.push_back(lightAt(left, float(t.y) + 0.5f - (left ? kLeft.y : kRight.y)));
        }
        pages = dilate(map, values, 2);
        before = pages[0];
        seams = findSeams(geometry, kPage);
        stitchSeams(map, seams, lightSeamWeights(seams, pages, noLight(pages)), pages);
    }
    CutPlane(vec3 left, vec3 right) : CutPlane(16.0f, [&](bool isLeft, float) { return isLeft ? left : right; }) {}
    [[nodiscard]] vec3 lightAt(vec2 place) const { return bilinear(pages[0], place); }

    Scene scene;
    TexelMap map;
    std::vector<SeamSample> seams;
    std::vector<Image<vec3>> pages;
    Image<vec3> before;
};

/// Light that both sides of a cut hold with an offset: after stitching the bilinear values on both sides agree to a
/// hundredth, and texels away from it are untouched.
TEST(SeamsS6, BothSidesAgree)
{
    const CutPlane plane(vec3(2.1f, 1.0f, 0.4f), vec3(1.9f, 1.0f, 0.6f));
    ASSERT_GE(plane.seams.size(), 16u);
    for (const SeamSample& seam : plane.seams) {
        const vec3 a = plane.lightAt(seam.texelA);
        const vec3 b = plane.lightAt(seam.texelB);
        EXPECT_NEAR(a.x, b.x, 0.01f * 2.0f);
        EXPECT_NEAR(a.x, 2.0f, 0.06f);
        EXPECT_NEAR(a.z, b.z, 0.01f);
    }
    for (int y = 6; y < 19; ++y) EXPECT_EQ(plane.pages[0](10, y), plane.before(10, y));
}

/// Both sides of a cut have the same shadow across it, and nearly agree; but their texels lie differently along the
/// cut, so that bilinear light can only be the same on both where it runs straight. Charts of a few texels must not
/// lose their shadow for that: padding gives way, and the light of what is covered stays.
TEST(SeamsS6, NarrowChartsKeepTheirLight)
{
    for (const float texels : {2.0f, 3.0f, 5.0f}) {
        SCOPED_TRACE(testing::Message() << texels << " texels wide");
        const CutPlane plane(texels,
                             [](bool, float up) { return vec3(1.0f - 0.6f * glm::smoothstep(6.0f, 9.0f, up)); });
        double steps = 0.0;
        for (const SeamSample& seam : plane.seams)
            steps += double(std::abs(plane.lightAt(seam.texelA).x - plane.lightAt(seam.texelB).x));
        EXPECT_LT(steps / double(plane.seams.size()), 0.01);
        double squares = 0.0;
        for (const Texel& t : plane.map.texels) {
            const double change = double(plane.pages[0](t.x, t.y).x - plane.before(t.x, t.y).x);
            EXPECT_LT(std::abs(change), 0.1) << t.x << ", " << t.y;
            squares += change * change;
        }
        EXPECT_LT(std::sqrt(squares / double(plane.map.texels.size())), 0.02);
    }
}

/// Where one side lies in the sun and the other in the shade, something must stand on the cut: no light comes over.
TEST(SeamsS6, SunIsNotStitchedToShade)
{
    for (const float shade : {0.0f, 0.001f, 0.3f}) {
        const CutPlane plane(vec3(1.0f), vec3(shade));
        for (const SeamSample& seam : plane.seams) {
            EXPECT_NEAR(plane.lightAt(seam.texelA).x, 1.0f, 0.02f);
            EXPECT_NEAR(plane.lightAt(seam.texelB).x, shade, 0.02f);
        }
    }
}

/// A smooth bend of 50° between charts: the estimates of both sides may differ by a factor of four, and light is the
/// same on both after stitching. On a plane the same difference is an edge of light, and stays.
TEST(SeamsS6, LightOfBendsIsContinuous)
{
    for (const float degrees : {50.0f, 0.0f}) {
        const float angle = glm::radians(degrees);
        Scene scene;
        const int grey = addMaterial(scene, vec3(0.5f));
        const vec2 left(4.3f, 4.6f);
        const vec2 right(30.8f, 30.1f);
        addRectangle(scene, {vec3(0), vec3(1, 0, 0), vec3(0, 1, 0)}, grey, kPage, {left, left + 16.0f});
        addRectangle(scene, {vec3(1, 0, 0), vec3(std::cos(angle), 0, -std::sin(angle)), vec3(0, 1, 0)}, grey, kPage,
                     {right, right + 16.0f});
        for (Mesh& mesh : scene.meshes)
            mesh.parts[0].normals.assign(4, vec3(std::sin(0.5f * angle), 0, std::cos(0.5f * angle)));
        const BakeGeometry geometry = flattenGeometry(scene, kPage, GeometryFilter::Static);
        const TexelMap map = rasterizeTexels(geometry, kPage, 1);
        std::vector<vec3> values;
        for (const Texel& t : map.texels) values.emplace_back(t.x < 25 ? 4.0f : 1.0f);
        std::vector<Image<vec3>> pages = dilate(map, values, 2);
        const std::vector<SeamSample> seams = findSeams(geometry, kPage);
        ASSERT_GE(seams.size(), 16u);
        stitchSeams(map, seams, lightSeamWeights(seams, pages, noLight(pages)), pages);
        for (const SeamSample& seam : seams) {
            const vec2 sides(bilinear(pages[0], seam.texelA).x, bilinear(pages[0], seam.texelB).x);
            if (degrees > 0.0f) {
                EXPECT_NEAR(sides.x, sides.y, 0.05f * std::min(sides.x, sides.y));
            } else {
                EXPECT_NEAR(std::max(sides.x, sides.y), 4.0f, 0.05f);
                EXPECT_NEAR(std::min(sides.x, sides.y), 1.0f, 0.05f);
            }
        }
    }
}

/// The two sides of a curtain meet in a hem whose normals are as smooth as a bend's. The bend is a seam, the hem is
/// not.
TEST(SeamsS6, HemsAreCorners)
{
    for (const float degrees : {20.0f, 60.0f, 150.0f, 180.0f}) {
        const float angle = glm::radians(degrees);
        Scene scene;
        const int grey = addMaterial(scene, vec3(0.5f));
        const vec3 normal(std::sin(0.5f * angle), 0, std::cos(0.5f * angle));
        const auto bend = [&] {
            MeshPart& part = scene.meshes.back().parts[0];
            for (std::size_t v = 0; v < part.positions.size(); ++v) {
                if (part.positions[v].x == 1.0f && part.positions[v].z == 0.0f) part.normals[v] = normal;
            }
        };
        addRectangle(scene, {vec3(0), vec3(1, 0, 0), vec3(0, 1, 0)}, grey, kPage, {vec2(4), vec2(20)});
        bend();
        addRectangle(scene, {vec3(1, 0, 0), vec3(std::cos(angle), 0, -std::sin(angle)), vec3(0, 1, 0)}, grey, kPage,
                     {vec2(30), vec2(46)});
        bend();
        const BakeGeometry geometry = flattenGeometry(scene, kPage, GeometryFilter::Static);
        EXPECT_EQ(findSeams(geometry, kPage).empty(), degrees > 90.0f) << degrees;
    }
}

/// Neighbours that are cut differently, and one that is not quite where it should be: every place along the common line
/// has its sample, and both its sides are the same place in the world.
TEST(SeamsS6, EdgesThatShareOnlyAStretchAreFound)
{
    Scene scene;
    const int grey = addMaterial(scene, vec3(0.5f));
    addRectangle(scene, {vec3(0, 0, 0), vec3(3, 0, 0), vec3(0, 0, -1)}, grey, kPage, {vec2(2), vec2(32, 12)});
    const float ends[] = {0.5f, 1.25f, 2.0f, 3.5f}; // the last one stands out
    for (int i = 0; i < 3; ++i) {
        const vec3 origin(ends[i], i == 1 ? 0.0005f : 0.0f, 1.0f);
        addRectangle(scene, {origin, vec3(ends[i + 1] - ends[i], 0, 0), vec3(0, 0, -1)}, grey, kPage,
                     {vec2(2 + 16 * i, 20), vec2(2 + 16 * i + 10 * (ends[i + 1] - ends[i]), 30)});
    }
    // A wall on the same line is a corner, a shelf above it another line.
    addRectangle(scene, {vec3(0, 0, 0), vec3(2, 0, 0), vec3(0, 1, 0)}, grey, kPage, {vec2(2, 40), vec2(22, 50)});
    addRectangle(scene, {vec3(0, 0.1f, 0), vec3(2, 0, 0), vec3(0, 0, 1)}, grey, kPage, {vec2(30, 40), vec2(50, 50)});
    const std::vector<SeamSample> seams = findSeams(flattenGeometry(scene, kPage, GeometryFilter::Static), kPage);
    std::vector<float> places;
    for (const SeamSample& seam : seams) {
        const bool first = seam.texelA.y < 15.0f;
        const vec2 wide = first ? seam.texelA : seam.texelB;
        const vec2 cut = first ? seam.texelB : seam.texelA;
        const int piece = int((cut.x - 2.0f) / 16.0f);
        if (wide.y > 15.0f && wide.y < 35.0f && cut.y < 35.0f) continue; // between the three
        ASSERT_LT(wide.y, 15.0f);
        ASSERT_LT(cut.y, 35.0f) << "floor only";
        const float x = (wide.x - 2.0f) / 10.0f;
        EXPECT_NEAR(x, ends[piece] + (cut.x - 2.0f - 16.0f * float(piece)) / 10.0f, 1.0e-3f);
        places.push_back(x);
    }
    std::sort(places.begin(), places.end());
    ASSERT_FALSE(places.empty());
    EXPECT_NEAR(places.front(), 0.5f, 0.06f);
    EXPECT_NEAR(places.back(), 3.0f, 0.06f);
    for (std::size_t i = 1; i < places.size(); ++i) EXPECT_LT(places[i] - places[i - 1], 0.1f);
}

/// Parts of the least squares have no unknown in common, and hold every term and unknown once.
TEST(SeamsS6, PartsAreIndependent)
{
    constexpr uint32_t kUnknowns = 40'000;
    std::vector<SeamTerm> terms(5'000);
    for (uint32_t t = 0; t < terms.size(); ++t) {
        // Chains of ten terms with neighbours in common; unknowns of a chain lie apart.
        for (uint32_t i = 0; i < 8; ++i) terms[t].unknown[i] = (t / 10 + 500 * (t % 10 + i)) % kUnknowns;
    }
    const SeamParts split = partsOf(terms, kUnknowns);
    EXPECT_GT(split.parts.size(), 3u);
    std::vector<int> partOf(kUnknowns, -1);
    std::size_t termCount = 0;
    for (std::size_t p = 0; p < split.parts.size(); ++p) {
        for (std::size_t i = 0; i < split.parts[p].unknowns.size(); ++i) {
            const uint32_t u = split.parts[p].unknowns[i];
            EXPECT_EQ(partOf[u], -1);
            EXPECT_EQ(split.placeOf[u], i);
            partOf[u] = int(p);
        }
    }
    EXPECT_EQ(std::count(partOf.begin(), partOf.end(), -1), 0);
    for (std::size_t p = 0; p < split.parts.size(); ++p) {
        for (const uint32_t t : split.parts[p].terms) {
            for (const uint32_t u : terms[t].unknown) EXPECT_EQ(partOf[u], int(p));
        }
        termCount += split.parts[p].terms.size();
    }
    EXPECT_EQ(termCount, terms.size());
}

/// A box's edges are corners, not seams: its faces keep their own light.
TEST(SeamsS6, HardEdgesAreLeftAlone)
{
    Scene scene;
    addBox(scene, vec3(-1), vec3(1), addMaterial(scene, vec3(0.5f)), false, kPage);
    EXPECT_TRUE(findSeams(flattenGeometry(scene, kPage, GeometryFilter::Static), kPage).empty());
}

} // namespace
} // namespace halflight::test::seams_test
