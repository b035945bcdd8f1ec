// Charts of shapes, shared layouts, robustness and the contract of unwrap().

#include "shapes.h"
#include "unwrap_and_check.h"

#include "halflight/base/parallel.h"

#include <atomic>
#include <cmath>
#include <functional>
#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>
#include <set>
#include <utility>

namespace halflight::unwrap_test {
namespace {

TEST(UnwrapShapes, PlaneIsOneChartWithoutStretch)
{
    const UnwrappedScene result = unwrapAndCheck(shapes::scene(shapes::plane(3.0f, 2.0f, 20)));
    EXPECT_EQ(result.chartCount, 1);
    EXPECT_NEAR(result.meshes[0].areaStretch, 1.0f, 1e-4f);
}

TEST(UnwrapShapes, BoxIsSixChartsWithoutStretch)
{
    const UnwrappedScene result = unwrapAndCheck(shapes::scene(shapes::box({1.0f, 2.0f, 3.0f})));
    EXPECT_LE(result.chartCount, 6);
    EXPECT_NEAR(result.meshes[0].areaStretch, 1.0f, 1e-4f);
}

/// A plate thinner than a texel: its top keeps a chart of its own, so that no texel of it averages in the sides' light.
TEST(UnwrapShapes, ThinSidesStayApartFromLargeFaces)
{
    UnwrapSettings settings;
    settings.texelsPerMeter = 20.0f;
    const auto result = unwrap(shapes::scene(shapes::box(vec3(2.0f, 0.01f, 2.0f))), settings);
    ASSERT_TRUE(result) << result.error().text();
    const MeshPart& part = result->scene.meshes[0].parts[0];
    // Top and bottom are the triangles with normals up and down; no other triangle shares a lightmap point with them.
    std::set<std::pair<float, float>> faces;
    std::set<std::pair<float, float>> sides;
    for (std::size_t i = 0; i < part.indices.size(); ++i) {
        const uint32_t v = part.indices[i];
        (std::abs(part.normals[v].y) > 0.5f ? faces : sides).insert({part.lightmapUv[v].x, part.lightmapUv[v].y});
    }
    for (const auto& point : sides) EXPECT_FALSE(faces.contains(point));
}

TEST(UnwrapShapes, CylinderIsFourChartsWithoutStretch)
{
    const UnwrappedScene result = unwrapAndCheck(shapes::scene(shapes::cylinder(1.0f, 3.0f, 32)));
    EXPECT_LE(result.chartCount, 4);
    EXPECT_NEAR(result.meshes[0].areaStretch, 1.0f, 1e-3f);
}

TEST(UnwrapShapes, SphereIsAHandfulOfChartsWithLittleStretch)
{
    const UnwrappedScene result = unwrapAndCheck(shapes::scene(shapes::sphere(1.0f, 32, 64)));
    EXPECT_LE(result.chartCount, 6);
    EXPECT_LT(result.meshes[0].areaStretch, 1.08f);
}

TEST(UnwrapObjects, FiveHundredCubesShareOneLayout)
{
    Scene scene = shapes::scene(shapes::box());
    for (int i = 1; i < 501; ++i)
        shapes::add(scene, 0, glm::rotate(mat4(1.0f), float(i), glm::normalize(vec3(1, float(i), 2))));
    const UnwrappedScene result = unwrapAndCheck(scene);
    EXPECT_EQ(result.scene.meshes.size(), 1u);
    EXPECT_EQ(result.pageCount, 1);
    EXPECT_EQ(result.chartCount, 501 * 6);
    for (const Object& object : result.scene.objects) {
        const vec2 texels = object.lightmap.offset * float(result.pageSize);
        EXPECT_EQ(texels, glm::round(texels)); // whole texels
    }
}

TEST(UnwrapObjects, DifferentScalesGetMeshesOfTheirOwn)
{
    Scene scene = shapes::scene(shapes::box());
    for (const float scale : {1.01f, 2.0f, 2.02f, -2.0f, 5.0f})
        shapes::add(scene, 0, glm::scale(mat4(1.0f), vec3(scale)));
    const UnwrappedScene result = unwrapAndCheck(scene);
    ASSERT_EQ(result.scene.meshes.size(), 3u); // 1, 2 and 5
    for (const Mesh& mesh : result.scene.meshes) EXPECT_EQ(mesh.sourceMesh, 0);
    EXPECT_EQ(result.scene.objects[0].mesh, result.scene.objects[1].mesh);
    EXPECT_EQ(result.scene.objects[2].mesh, result.scene.objects[4].mesh);
    EXPECT_EQ(result.scene.objects[5].lightmap.scale, vec2(1.0f)); // its only object: page coordinates
}

TEST(UnwrapObjects, InstancesOfANodeShareALayoutAtAnyScale)
{
    // Two nodes: the instances of each differ in scale, and a plain object has the mesh as well.
    Scene scene = shapes::scene(shapes::box());
    for (const float scale : {1.0f, 0.1f, 3.0f, 2.0f, 7.0f, 4.0f}) {
        shapes::add(scene, 0, glm::scale(mat4(1.0f), vec3(scale)));
        Object& object = scene.objects.back();
        const int added = int(scene.objects.size()) - 2;
        object.sourceNode = 1 + added / 3;
        object.sourceInstance = added % 3;
    }
    UnwrapSettings settings;
    settings.texelsPerMeter = 20.0f;
    const UnwrappedScene result = unwrapAndCheck(scene, settings);
    const std::vector<Object>& objects = result.scene.objects;
    for (std::size_t first : {1u, 4u}) {
        for (std::size_t i = first; i < first + 3; ++i) {
            EXPECT_EQ(objects[i].mesh, objects[first].mesh);
            EXPECT_EQ(objects[i].lightmap.scale, objects[first].lightmap.scale);
            EXPECT_GE(objects[i].lightmap.page, 0);
        }
    }
    EXPECT_NE(objects[1].mesh, objects[4].mesh);
    EXPECT_NE(objects[0].mesh, objects[1].mesh);
    // The largest has the density asked for, and the others as many texels.
    EXPECT_NEAR(texelAreaOf(result, 3), 6.0 * 9.0 * 400.0, 10.0);
    EXPECT_NEAR(texelAreaOf(result, 2), 6.0 * 9.0 * 400.0, 10.0);
    EXPECT_NEAR(texelAreaOf(result, 5), 6.0 * 49.0 * 400.0, 50.0);
    EXPECT_NEAR(texelAreaOf(result, 0), 6.0 * 400.0, 2.0);
}

TEST(UnwrapObjects, DynamicAndScaleZeroGetNoTexels)
{
    Scene scene = shapes::scene(shapes::box());
    shapes::add(scene, 0, mat4(1.0f));
    shapes::add(scene, 0, mat4(1.0f));
    scene.objects[0].isStatic = false;
    scene.objects[1].lightmapScale = 0.0f;
    const UnwrappedScene result = unwrapAndCheck(scene);
    EXPECT_EQ(result.scene.objects[0].lightmap.page, -1);
    EXPECT_EQ(result.scene.objects[1].lightmap.page, -1);
    EXPECT_EQ(result.scene.objects[2].lightmap.page, 0);
    EXPECT_EQ(unwrapAndCheck(Scene()).pageCount, 0);
}

TEST(UnwrapObjects, TransformsThatAreNotFiniteAreLeftOut)
{
    Scene scene = shapes::scene(shapes::box());
    shapes::add(scene, 0, glm::scale(mat4(1.0f), vec3(std::numeric_limits<float>::quiet_NaN())));
    shapes::add(scene, 0, glm::scale(mat4(1.0f), vec3(kInfinity)));
    shapes::add(scene, 0, glm::scale(mat4(1.0f), vec3(0.0f)));
    shapes::add(scene, 0, glm::scale(mat4(1.0f), vec3(1.0f, 1.0f, 0.0f)));
    const Result<UnwrappedScene> result = unwrap(scene, {});
    ASSERT_TRUE(result);
    EXPECT_EQ(result->warnings.size(), 2u);
    EXPECT_EQ(result->scene.objects[1].lightmap.page, -1);
    EXPECT_EQ(result->scene.objects[2].lightmap.page, -1);
    EXPECT_EQ(result->scene.objects[3].lightmap.page, 0);
    EXPECT_EQ(checkAtlas(*result, 2).fault, "");
}

TEST(UnwrapRobustness, TinyAndHugeScales)
{
    for (const float scale : {1e-3f, 1.0f, 1e4f}) {
        const UnwrappedScene result =
            unwrapAndCheck(shapes::scene(shapes::sphere(1.0f, 16, 32), glm::scale(mat4(1.0f), vec3(scale))));
        EXPECT_LE(result.chartCount, 6);
    }
}

TEST(UnwrapRobustness, PaddingAndPageSizes)
{
    const Scene scene = shapes::scene(shapes::together(shapes::sphere(1.0f, 12, 24), shapes::box(vec3(3.0f))));
    for (const int padding : {1, 2, 4, 7}) {
        UnwrapSettings settings;
        settings.paddingTexels = padding;
        settings.pageSize = 200; // no power of two
        unwrapAndCheck(scene, settings);
    }
    UnwrapSettings settings;
    settings.pageSize = 4096;
    unwrapAndCheck(shapes::scene(shapes::box()), settings);
}

/// A mesh of one part from loose triangles.
Mesh soup(std::vector<vec3> positions, std::vector<uint32_t> indices)
{
    Mesh mesh;
    MeshPart& part = mesh.parts.emplace_back();
    part.normals.assign(positions.size(), vec3(0, 1, 0));
    part.positions = std::move(positions);
    part.indices = std::move(indices);
    return mesh;
}

TEST(UnwrapRobustness, DegenerateDuplicatedAndNonManifoldTriangles)
{
    const std::vector<vec3> p{{0, 0, 0},  {1, 0, 0}, {0, 1, 0},    {0, 0, 1}, {0, -1, 0},
                              {0, 0, -1}, {2, 0, 0}, {0.5f, 0, 0}, {7, 7, 7}};
    // Nothing but triangles without area: a point, a line, a line with a vertex in its middle.
    unwrapAndCheck(shapes::scene(soup(p, {0, 0, 0, 0, 1, 1, 0, 1, 6, 8, 8, 8})));
    // The same triangle four times, twice from behind.
    EXPECT_EQ(unwrapAndCheck(shapes::scene(soup(p, {0, 1, 2, 0, 1, 2, 0, 2, 1, 1, 0, 2}))).chartCount, 4);
    // Four wings on one edge, either way round; a bow tie; a sliver; a triangle alone.
    unwrapAndCheck(shapes::scene(soup(p, {0, 1, 2, 0, 1, 3, 1, 0, 4, 0, 1, 5, 0, 7, 1, 2, 0, 3, 4, 0, 5, 6, 8, 2})));
    // A degenerate triangle between two others, and a T-junction.
    unwrapAndCheck(shapes::scene(soup(p, {0, 1, 2, 0, 7, 1, 7, 0, 4, 1, 7, 4})));
}

TEST(UnwrapRobustness, ThousandsOfTrianglesOnOneEdge)
{
    std::vector<vec3> p{{0, 0, 0}, {1, 0, 0}};
    std::vector<uint32_t> indices;
    for (uint32_t i = 0; i < 3000; ++i) {
        p.emplace_back(0.5f, std::cos(0.002f * float(i)), std::sin(0.002f * float(i)));
        for (const uint32_t v : {i % 2, 1 - i % 2, i + 2}) indices.push_back(v);
    }
    unwrapAndCheck(shapes::scene(soup(p, indices)));
}

TEST(UnwrapRobustness, RandomSoup)
{
    uint32_t state = 1;
    const auto random = [&] { return float((state = state * 1664525u + 1013904223u) >> 8) * 0x1p-24f; };
    for (int run = 0; run < 8; ++run) {
        std::vector<vec3> p;
        std::vector<uint32_t> indices;
        for (int i = 0; i < 60; ++i)
            p.emplace_back(random(), random(), run % 2 == 0 ? random() : 0.0f); // every other run is flat
        for (int i = 0; i < 900; ++i) indices.push_back(uint32_t(random() * 60.0f));
        UnwrapSettings settings;
        settings.pageSize = 256;
        unwrapAndCheck(shapes::scene(soup(p, indices)), settings);
    }
}

TEST(UnwrapRobustness, SurfacesThatCrossThemselvesAreSplit)
{
    // A spiral ramp of three turns lies over itself when projected; a Moebius strip has no side; a saddle and a wave
    // bend.
    const auto ramp = [](float s, float t) {
        return vec3((1.0f + t) * std::cos(18.84f * s), 0.05f * s, (1.0f + t) * std::sin(18.84f * s));
    };
    const UnwrappedScene spiral = unwrapAndCheck(shapes::scene(shapes::grid(200, 4, ramp)));
    EXPECT_GE(spiral.chartCount, 3);
    EXPECT_LE(spiral.chartCount, 12);
    unwrapAndCheck(shapes::scene(shapes::grid(100, 4, [](float s, float t) {
        const float a = 2.0f * kPi * s, r = 1.0f + (t - 0.5f) * std::cos(0.5f * a);
        return vec3(r * std::cos(a), (t - 0.5f) * std::sin(0.5f * a), r * std::sin(a));
    })));
    unwrapAndCheck(shapes::scene(shapes::grid(
        60, 60, [](float s, float t) { return vec3(s, 0.2f * std::sin(20.0f * s) * std::cos(17.0f * t), t); })));
    // A roll of cloth: developable, but no projection is without overlap.
    const UnwrappedScene roll = unwrapAndCheck(shapes::scene(shapes::grid(300, 3, [](float s, float t) {
        const float a = 15.0f * s;
        return vec3((0.2f + 0.03f * a) * std::cos(a), t, (0.2f + 0.03f * a) * std::sin(a));
    })));
    EXPECT_LE(roll.chartCount, 12);
    EXPECT_LT(roll.meshes[0].areaStretch, 1.05f);
}

TEST(UnwrapContract, SameBytesWhateverTheNumberOfThreads)
{
    Scene scene = shapes::scene(shapes::sphere(1.0f, 40, 80));
    scene.meshes.push_back(shapes::cylinder(1.0f, 2.0f, 50));
    shapes::add(scene, 1, mat4(1.0f));
    shapes::add(scene, 1, mat4(1.0f));
    const auto coordinates = [&](int threads) {
        const ThreadLimit limit(threads);
        const Result<UnwrappedScene> result = unwrap(scene, {});
        std::vector<vec2> all;
        for (const Mesh& mesh : result->scene.meshes) {
            for (const MeshPart& part : mesh.parts)
                all.insert(all.end(), part.lightmapUv.begin(), part.lightmapUv.end());
        }
        for (const Object& object : result->scene.objects) all.push_back(object.lightmap.offset);
        return all;
    };
    const std::vector<vec2> one = coordinates(1);
    EXPECT_EQ(one, coordinates(2));
    EXPECT_EQ(one, coordinates(7));
}

TEST(UnwrapContract, SettingsOutOfRangeAreErrors)
{
    const Scene scene = shapes::scene(shapes::box());
    for (const auto& spoil : std::vector<std::function<void(UnwrapSettings&)>>{
             [](UnwrapSettings& s) { s.pageSize = 32; }, [](UnwrapSettings& s) { s.pageSize = 16384; },
             [](UnwrapSettings& s) { s.paddingTexels = 0; }, [](UnwrapSettings& s) { s.texelsPerMeter = -1.0f; },
             [](UnwrapSettings& s) { s.texelsPerMeter = kInfinity; }}) {
        UnwrapSettings settings;
        spoil(settings);
        const Result<UnwrappedScene> result = unwrap(scene, settings);
        ASSERT_FALSE(result);
        EXPECT_EQ(result.error().code, ErrorCode::InvalidArgument);
    }
}

TEST(UnwrapContract, CanBeCancelled)
{
    std::atomic<bool> cancel = false;
    Progress progress;
    progress.cancel = &cancel;
    progress.report = [&](std::string_view stage, double fraction) {
        EXPECT_GE(fraction, 0.0);
        EXPECT_LE(fraction, 1.0);
        if (stage == "pack") cancel = true;
    };
    const Result<UnwrappedScene> result = unwrap(shapes::scene(shapes::sphere(1.0f, 20, 40)), {}, progress);
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, ErrorCode::Cancelled);
}

} // namespace
} // namespace halflight::unwrap_test
