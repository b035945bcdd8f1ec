#include "atlas_check.h"
#include "shapes.h"

#include "halflight/base/parallel.h"

#include <atomic>
#include <cmath>
#include <functional>
#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>
#include <set>

namespace halflight::unwrap_test {
namespace {

UnwrappedScene unwrapAndCheck(const Scene& scene, const UnwrapSettings& settings = {})
{
    Result<UnwrappedScene> result = unwrap(scene, settings);
    EXPECT_TRUE(result) << (result ? "" : result.error().text());
    if (!result) return {};
    const AtlasCheck check = checkAtlas(*result, settings.paddingTexels);
    EXPECT_EQ(check.fault, "");
    EXPECT_EQ(checkMeshes(scene, *result), "");
    return std::move(*result);
}

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

/// Texels of an object's triangles, in float as a renderer has them.
double texelAreaOf(const UnwrappedScene& result, std::size_t object)
{
    const Object& o = result.scene.objects[object];
    double sum = 0.0;
    for (const MeshPart& part : result.scene.meshes[std::size_t(o.mesh)].parts) {
        for (std::size_t i = 0; i + 2 < part.indices.size(); i += 3) {
            glm::dvec2 c[3];
            for (std::size_t k = 0; k < 3; ++k) {
                c[k] = glm::dvec2(o.lightmap.scale * part.lightmapUv[part.indices[i + k]] + o.lightmap.offset) *
                       double(result.pageSize);
            }
            sum += 0.5 * std::abs((c[1].x - c[0].x) * (c[2].y - c[0].y) - (c[1].y - c[0].y) * (c[2].x - c[0].x));
        }
    }
    return sum;
}

TEST(UnwrapDensity, IsTexelsPerMeterOfTheWorldForEveryScaleAndMirror)
{
    Scene scene = shapes::scene(shapes::box(), glm::scale(mat4(1.0f), vec3(2.0f)));
    shapes::add(scene, 0, glm::scale(mat4(1.0f), vec3(-1.0f, 1.0f, 1.0f)));
    shapes::add(scene, 0, glm::scale(glm::rotate(mat4(1.0f), 1.0f, vec3(1, 2, 3)), vec3(1.0f, 3.0f, 0.5f)));
    scene.objects[1].lightmapScale = 0.5f;
    UnwrapSettings settings;
    settings.texelsPerMeter = 40.0f;
    const UnwrappedScene result = unwrapAndCheck(scene, settings);
    EXPECT_EQ(result.texelsPerMeter, 40.0f);
    EXPECT_NEAR(texelAreaOf(result, 0), 6.0 * 4.0 * 1600.0, 6.0 * 4.0 * 1.6);
    EXPECT_NEAR(texelAreaOf(result, 1), 6.0 * 400.0, 6.0 * 0.4);
    EXPECT_NEAR(texelAreaOf(result, 2), 2.0 * (3.0 + 1.5 + 0.5) * 1600.0, 2.0 * 5.0 * 1.6);
}

TEST(UnwrapDensity, FitsOnePageAndFillsIt)
{
    for (const int size : {64, 256, 1024}) {
        UnwrapSettings settings;
        settings.pageSize = size;
        Scene scene = shapes::scene(shapes::box());
        for (int i = 1; i < 40; ++i) {
            scene.meshes.push_back(shapes::box(vec3(1.0f, 1.0f + 0.1f * float(i), 0.5f)));
            shapes::add(scene, i, mat4(1.0f));
        }
        const UnwrappedScene result = unwrapAndCheck(scene, settings);
        EXPECT_EQ(result.pageCount, 1);
        EXPECT_EQ(result.pageSize, size);
        EXPECT_GT(result.coverageWithPadding, 0.85f);
    }
}

TEST(UnwrapDensity, UsesAsManyPagesAsItTakesAndKeepsAnObjectOnOne)
{
    Scene scene = shapes::scene(shapes::box());
    for (int i = 1; i < 20; ++i) {
        scene.meshes.push_back(shapes::cylinder(0.5f, 1.0f, 12 + i));
        shapes::add(scene, i, mat4(1.0f));
    }
    UnwrapSettings settings;
    settings.pageSize = 256;
    settings.texelsPerMeter = 40.0f;
    const UnwrappedScene result = unwrapAndCheck(scene, settings);
    EXPECT_EQ(result.texelsPerMeter, 40.0f);
    EXPECT_GE(result.pageCount, 3); // 20 objects of 4.5 to 6 square metres, 1600 texels each, on pages of 65536
    EXPECT_LE(result.pageCount, 4);
    EXPECT_TRUE(result.warnings.empty());
    for (const Object& object : result.scene.objects) EXPECT_GE(object.lightmap.page, 0);
}

TEST(UnwrapDensity, WhatDoesNotFitAPageGetsFewerTexelsAndAWarning)
{
    Scene scene = shapes::scene(shapes::plane(100.0f, 1.0f, 4));
    scene.meshes.push_back(shapes::box());
    shapes::add(scene, 1, mat4(1.0f));
    UnwrapSettings settings;
    settings.pageSize = 256;
    settings.texelsPerMeter = 20.0f;
    const UnwrappedScene result = unwrapAndCheck(scene, settings);
    EXPECT_EQ(result.warnings.size(), 1u);
    EXPECT_NEAR(texelAreaOf(result, 1), 6.0 * 400.0, 1.0);
}

TEST(UnwrapDensity, TooManyPagesAreAnErrorThatSaysWhatFits)
{
    // 1000 planes of 4 square metres: at 100 texels per metre 40000 texels each, some 610 pages of 65536 with padding
    // uncounted.
    Scene scene = shapes::scene(shapes::plane(2.0f, 2.0f));
    for (int i = 1; i < 1000; ++i) shapes::add(scene, 0, mat4(1.0f));
    UnwrapSettings settings;
    settings.pageSize = 256;
    settings.texelsPerMeter = 100.0f;
    const Result<UnwrappedScene> result = unwrap(scene, settings);
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, ErrorCode::InvalidArgument);
    const std::string& message = result.error().message;
    EXPECT_NE(message.find("256 are the most"), std::string::npos) << message;
    const std::size_t at = message.rfind(": ");
    ASSERT_NE(at, std::string::npos) << message;
    // What it says does fit.
    settings.texelsPerMeter = std::stof(message.substr(at + 2));
    EXPECT_GT(settings.texelsPerMeter, 50.0f) << message;
    EXPECT_LT(settings.texelsPerMeter, 65.0f) << message;
    const Result<UnwrappedScene> less = unwrap(scene, settings);
    ASSERT_TRUE(less) << less.error().text();
    EXPECT_LE(less->pageCount, kMaxPages);
    EXPECT_EQ(less->texelsPerMeter, settings.texelsPerMeter);
}

TEST(UnwrapDensity, ObjectsThatNeedManyPagesEachAreShrunkAtOnce)
{
    // A page each, where some fifty were asked.
    Scene scene = shapes::scene(shapes::sphere(1.0f, 20, 40));
    shapes::add(scene, 0, mat4(1.0f));
    scene.meshes.push_back(shapes::box());
    shapes::add(scene, 1, mat4(1.0f));
    UnwrapSettings settings;
    settings.pageSize = 256;
    settings.texelsPerMeter = 500.0f;
    const UnwrappedScene result = unwrapAndCheck(scene, settings);
    EXPECT_LE(result.pageCount, 3);
    EXPECT_EQ(result.warnings.size(), 2u); // one for each mesh
    EXPECT_GT(result.coverage, 0.3f);
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

TEST(UnwrapVertices, SourceVertexIsComposed)
{
    Mesh mesh = shapes::sphere(1.0f, 16, 32);
    MeshPart& part = mesh.parts[0];
    const auto count = uint32_t(part.positions.size());
    for (uint32_t v = 0; v < count; ++v) part.sourceVertex.push_back(1000 - v); // as a reader may have left it
    part.uv[0].resize(count);
    part.tangents.resize(count);
    part.colors.resize(count);
    for (uint32_t v = 0; v < count; ++v) part.colors[v] = vec4(float(v));
    const UnwrappedScene result = unwrapAndCheck(shapes::scene(mesh));
    const MeshPart& after = result.scene.meshes[0].parts[0];
    EXPECT_GT(after.positions.size(), part.positions.size()); // it was cut
    ASSERT_EQ(after.sourceVertex.size(), after.positions.size());
    for (std::size_t v = 0; v < after.positions.size(); ++v)
        EXPECT_EQ(after.sourceVertex[v], 1000 - uint32_t(after.colors[v].x));
}

TEST(UnwrapVertices, LightmapTexCoordIsOneThatAllMaterialsOfTheMeshLeaveFree)
{
    Scene scene = shapes::scene(shapes::together(shapes::plane(), shapes::box()));
    scene.materials.resize(2);
    scene.materials[1].emissiveTexture.texture = 0;
    scene.materials[1].emissiveTexture.texCoord = 1;
    scene.textures.resize(1);
    scene.meshes[0].parts[0].material = 1;
    scene.meshes[0].parts[1].material = 0;
    for (const int last : {1, 0}) { // whichever part has that material
        std::swap(scene.meshes[0].parts[0].material, scene.meshes[0].parts[1].material);
        const UnwrappedScene result = unwrapAndCheck(scene);
        for (const MeshPart& part : result.scene.meshes[0].parts) EXPECT_EQ(part.lightmapTexCoord, 2) << last;
    }
    // The reader knows of textures that the scene does not hold.
    for (MeshPart& part : scene.meshes[0].parts) part.lightmapTexCoord = 3;
    const UnwrappedScene result = unwrapAndCheck(scene);
    for (const MeshPart& part : result.scene.meshes[0].parts) EXPECT_EQ(part.lightmapTexCoord, 3);
}

/// A plane with TEXCOORD_1 filling a rectangle of the uv square.
Mesh planeWithUv(vec2 from, vec2 to)
{
    Mesh mesh = shapes::plane(1.0f, 1.0f, 4);
    for (const vec3 p : mesh.parts[0].positions)
        mesh.parts[0].uv[1].push_back(glm::mix(from, to, vec2(p.x + 0.5f, p.z + 0.5f)));
    return mesh;
}

TEST(UnwrapKeep, AtlasThatDoesNotOverlapStaysAsItIs)
{
    Scene scene = shapes::scene(planeWithUv({0.0f, 0.0f}, {0.45f, 0.45f}));
    scene.meshes.push_back(planeWithUv({0.5f, 0.0f}, {0.9f, 0.4f}));
    shapes::add(scene, 1, mat4(1.0f));
    for (const UvMode mode : {UvMode::Keep, UvMode::Auto}) {
        UnwrapSettings settings;
        settings.uvMode = mode;
        settings.pageSize = 512;
        const UnwrappedScene result = unwrapAndCheck(scene, settings);
        EXPECT_EQ(result.pageSize, 512);
        EXPECT_EQ(result.pageCount, 1);
        for (std::size_t o = 0; o < 2; ++o) {
            EXPECT_TRUE(result.meshes[o].kept);
            EXPECT_EQ(result.scene.objects[o].lightmap.scale, vec2(1.0f));
            EXPECT_EQ(result.scene.objects[o].lightmap.offset, vec2(0.0f));
            EXPECT_EQ(result.scene.meshes[o].parts[0].lightmapUv, scene.meshes[o].parts[0].uv[1]);
        }
        EXPECT_NEAR(result.texelsPerMeter, 512.0 * std::sqrt((0.45 * 0.45 + 0.4 * 0.4) / 2.0), 0.1);
    }
}

TEST(UnwrapKeep, LayoutsThatOverlapOneAnotherArePacked)
{
    Scene scene = shapes::scene(planeWithUv({0.1f, 0.1f}, {0.9f, 0.9f}));
    shapes::add(scene, 0, glm::scale(mat4(1.0f), vec3(2.0f)));
    scene.meshes.push_back(planeWithUv({0.0f, 0.0f}, {1.0f, 1.0f}));
    shapes::add(scene, 1, mat4(1.0f));
    UnwrapSettings settings;
    settings.uvMode = UvMode::Keep;
    settings.texelsPerMeter = 50.0f;
    const UnwrappedScene result = unwrapAndCheck(scene, settings);
    EXPECT_EQ(result.scene.meshes.size(), 2u);
    EXPECT_NEAR(texelAreaOf(result, 0), 2500.0, 5.0);
    EXPECT_NEAR(texelAreaOf(result, 1), 10000.0, 20.0);
    EXPECT_NEAR(texelAreaOf(result, 2), 2500.0, 5.0);
    EXPECT_EQ(result.scene.meshes[0].parts[0].lightmapUv, scene.meshes[0].parts[0].uv[1]);
}

TEST(UnwrapKeep, SaysWhyTexCoord1IsNotKept)
{
    const auto reasonFor = [](const std::function<void(MeshPart&)>& spoil, const char* expected) {
        Scene scene = shapes::scene(planeWithUv({0.1f, 0.1f}, {0.9f, 0.9f}));
        spoil(scene.meshes[0].parts[0]);
        const UnwrappedScene result = unwrapAndCheck(scene);
        ASSERT_EQ(result.meshes.size(), 1u);
        EXPECT_FALSE(result.meshes[0].kept);
        EXPECT_NE(result.meshes[0].reason.find(expected), std::string::npos) << result.meshes[0].reason;
        UnwrapSettings settings;
        settings.uvMode = UvMode::Keep;
        const Result<UnwrappedScene> kept = unwrap(scene, settings);
        ASSERT_FALSE(kept);
        EXPECT_EQ(kept.error().code, ErrorCode::FileInvalid);
        EXPECT_EQ(kept.error().object, "/meshes/0");
        EXPECT_NE(kept.error().message.find(expected), std::string::npos);
    };
    reasonFor([](MeshPart& part) { part.uv[1][3].x = 1.01f; }, "leaves [0,1]");
    reasonFor([](MeshPart& part) { part.uv[1][3].y = std::numeric_limits<float>::quiet_NaN(); }, "not finite");
    reasonFor([](MeshPart& part) { part.uv[1][6] = vec2(0.8f, 0.45f); }, "overlaps itself");
    reasonFor([](MeshPart& part) { std::fill(part.uv[1].begin(), part.uv[1].end(), vec2(0.5f)); }, "no area");
}

TEST(UnwrapKeep, ChartsThatComeTooCloseAreUnwrappedInAutoAndNamedInKeep)
{
    // Two planes in one mesh, 0.003 apart in uv: a texel and a half of 512.
    Scene scene = shapes::scene(
        shapes::together(planeWithUv({0.0f, 0.0f}, {0.4985f, 1.0f}), planeWithUv({0.5015f, 0.0f}, {1.0f, 1.0f})));
    for (vec3& p : scene.meshes[0].parts[1].positions) p.y = 1.0f;
    UnwrapSettings settings;
    settings.pageSize = 512;
    const UnwrappedScene automatic = unwrapAndCheck(scene, settings);
    EXPECT_FALSE(automatic.meshes[0].kept);
    EXPECT_NE(automatic.meshes[0].reason.find("closer than 2 texels"), std::string::npos) << automatic.meshes[0].reason;
    settings.uvMode = UvMode::Keep;
    const Result<UnwrappedScene> kept = unwrap(scene, settings);
    ASSERT_TRUE(kept);
    EXPECT_TRUE(kept->meshes[0].kept);
    EXPECT_EQ(kept->warnings.size(), 1u);
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
