// Meshes cut where surfaces cross (spec S6: light stays on its side of a floor).

#include "atlas_check.h"
#include "shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>
#include <map>
#include <numeric>
#include <tuple>

namespace halflight::cuts_test {
namespace {

using Place = std::array<float, 3>;

constexpr float kHeight = 0.137f; ///< of the floor over the middle of the walls

Place placeOf(vec3 p)
{
    p += vec3(0.0f);
    return {p.x, p.y, p.z};
}

/// Walls of 2 m × 3 m × 2 m around a floor that goes a little through them. Attributes are linear in the place.
Scene house(int steps = 1)
{
    Mesh walls = shapes::box(vec3(2.0f, 3.0f, 2.0f));
    if (steps > 1) walls = shapes::cylinder(1.0f, 3.0f, steps);
    for (MeshPart& part : walls.parts) {
        for (const vec3 p : part.positions) {
            part.uv[0].emplace_back(0.5f * p.x + 0.25f * p.y, p.z - 0.125f * p.y);
            part.colors.emplace_back(0.1f * p + 0.5f, 1.0f);
        }
    }
    walls.sourceMesh = 0;
    Scene scene = shapes::scene(walls);
    scene.meshes.push_back(shapes::plane(2.4f, 2.4f));
    scene.meshes.back().sourceMesh = 1;
    shapes::add(scene, 1, glm::translate(mat4(1.0f), vec3(0.0f, kHeight, 0.0f)));
    return scene;
}

UnwrapSettings settings()
{
    UnwrapSettings s;
    s.texelsPerMeter = 20.0f;
    s.pageSize = 512;
    return s;
}

/// All crossings of the walls hide their sides from one another.
std::vector<uint8_t> ofWalls(const Scene&, std::span<const CrossingPoint> points)
{
    std::vector<uint8_t> hidden;
    for (const CrossingPoint& p : points) hidden.push_back(p.object == 0 ? 1 : 0);
    return hidden;
}

UnwrappedScene cutAndCheck(const Scene& scene, const CrossingTest& test = ofWalls)
{
    Result<UnwrappedScene> result = unwrap(scene, settings(), {}, test);
    EXPECT_TRUE(result) << (result ? "" : result.error().text());
    if (!result) return {};
    EXPECT_EQ(checkAtlas(*result, settings().paddingTexels).fault, "");
    return std::move(*result);
}

double areaOf(const Mesh& mesh)
{
    double area = 0.0;
    for (const MeshPart& part : mesh.parts) {
        for (std::size_t i = 0; i + 2 < part.indices.size(); i += 3) {
            const glm::dvec3 a(part.positions[part.indices[i]]);
            area += 0.5 * glm::length(glm::cross(glm::dvec3(part.positions[part.indices[i + 1]]) - a,
                                                 glm::dvec3(part.positions[part.indices[i + 2]]) - a));
        }
    }
    return area;
}

/// Edges that do not have one triangle on either side: T-junctions and holes.
std::size_t openEdges(const Mesh& mesh)
{
    std::map<std::pair<Place, Place>, int> sides;
    for (const MeshPart& part : mesh.parts) {
        for (std::size_t i = 0; i < part.indices.size(); ++i) {
            const Place a = placeOf(part.positions[part.indices[i]]);
            const Place b = placeOf(part.positions[part.indices[i % 3 == 2 ? i - 2 : i + 1]]);
            sides[std::minmax(a, b)] += a < b ? 1 : -1;
        }
    }
    return std::size_t(std::count_if(sides.begin(), sides.end(), [](const auto& edge) { return edge.second != 0; }));
}

/// Charts, connected by vertices, that have triangles on both sides of the floor.
int chartsAcross(const Mesh& mesh, float height = kHeight)
{
    int across = 0;
    for (const MeshPart& part : mesh.parts) {
        std::vector<uint32_t> root(part.positions.size());
        std::iota(root.begin(), root.end(), 0u);
        const auto find = [&](uint32_t v) {
            while (root[v] != v) v = root[v];
            return v;
        };
        for (std::size_t i = 0; i + 2 < part.indices.size(); i += 3) {
            for (std::size_t k = 1; k < 3; ++k) root[find(part.indices[i + k])] = find(part.indices[i]);
        }
        std::map<uint32_t, vec2> extent; // least and greatest height
        for (const uint32_t v : part.indices) {
            const float y = part.positions[v].y;
            auto& e = extent.try_emplace(find(v), y, y).first->second;
            e = vec2(std::min(e.x, y), std::max(e.y, y));
        }
        for (const auto& [chart, e] : extent) across += e.x < height - 1e-3f && e.y > height + 1e-3f ? 1 : 0;
    }
    return across;
}

TEST(CutsS6, ChartsEndAtTheFloorAndTheMeshStaysClosed)
{
    const Scene scene = house();
    const UnwrappedScene before = *unwrap(scene, settings());
    const UnwrappedScene after = cutAndCheck(scene);
    EXPECT_EQ(before.cuts, 0);
    EXPECT_EQ(chartsAcross(before.scene.meshes[0]), 4);
    EXPECT_EQ(after.cuts, 4);
    const Mesh& mesh = after.scene.meshes[0];
    EXPECT_EQ(chartsAcross(mesh), 0);
    EXPECT_EQ(openEdges(before.scene.meshes[0]), 0u);
    EXPECT_EQ(openEdges(mesh), 0u);
    EXPECT_NEAR(areaOf(mesh), areaOf(scene.meshes[0]), 1e-5);
    EXPECT_EQ(after.scene.meshes.size(), scene.meshes.size());
    EXPECT_EQ(after.scene.meshes[1].parts[0].indices, before.scene.meshes[1].parts[0].indices);
}

TEST(CutsS6, SmoothSurfacesAreCutAllRound)
{
    const Scene scene = house(24);
    const UnwrappedScene after = cutAndCheck(scene);
    EXPECT_EQ(after.cuts, 1);
    EXPECT_EQ(chartsAcross(after.scene.meshes[0]), 0);
    EXPECT_EQ(openEdges(after.scene.meshes[0]), 0u);
    EXPECT_NEAR(areaOf(after.scene.meshes[0]), areaOf(scene.meshes[0]), 1e-4);
}

/// The walls in two parts, as two primitives of a file: both get equal vertices on their common edges.
TEST(CutsS6, PartsOfAMeshStayJoined)
{
    Scene scene = house();
    MeshPart& walls = scene.meshes[0].parts[0];
    MeshPart other = walls;
    other.indices.assign(walls.indices.begin() + 15, walls.indices.end());
    walls.indices.resize(15);
    scene.meshes[0].parts.push_back(other);
    // Turned and scaled unevenly, so that places round.
    const mat4 turn = glm::rotate(mat4(1.0f), 0.37f, vec3(0.2f, 1.0f, 0.1f));
    for (Object& object : scene.objects) object.worldFromObject = turn * object.worldFromObject;
    const UnwrappedScene after = cutAndCheck(scene);
    EXPECT_EQ(after.cuts, 4);
    EXPECT_EQ(openEdges(after.scene.meshes[0]), 0u);
}

TEST(CutsS6, NewVerticesHaveTheAttributesOfTheirPlace)
{
    const UnwrappedScene after = cutAndCheck(house());
    const MeshPart& part = after.scene.meshes[0].parts[0];
    ASSERT_EQ(part.uv[0].size(), part.positions.size());
    ASSERT_EQ(part.colors.size(), part.positions.size());
    ASSERT_EQ(part.normals.size(), part.positions.size());
    ASSERT_EQ(part.sourceVertex.size(), part.positions.size());
    EXPECT_FALSE(part.cutVertices.empty());
    int made = 0;
    for (std::size_t v = 0; v < part.positions.size(); ++v) {
        const vec3 p = part.positions[v];
        EXPECT_NEAR(part.uv[0][v].x, 0.5f * p.x + 0.25f * p.y, 1e-5f);
        EXPECT_NEAR(part.uv[0][v].y, p.z - 0.125f * p.y, 1e-5f);
        EXPECT_NEAR(part.colors[v].y, 0.1f * p.y + 0.5f, 1e-5f);
        EXPECT_NEAR(glm::length(part.normals[v]), 1.0f, 1e-5f);
        if ((part.sourceVertex[v] & kCutVertex) == 0) continue;
        ++made;
        EXPECT_NEAR(p.y, kHeight, 1e-5f);
        const CutVertex& cut = part.cutVertices.at(part.sourceVertex[v] & ~kCutVertex);
        ASSERT_LT(std::max(cut.from, cut.to), 24u) << "vertices of the source";
        for (int c = 0; c < 3; ++c)
            EXPECT_EQ(p[c], cut.between(part.positions[cut.from][c], part.positions[cut.to][c]));
    }
    EXPECT_GE(made, 12); // two at each side of each wall and one in its diagonal
}

/// Without crossings the result has the bytes of one without a test.
TEST(CutsS6, NothingChangesWhereNothingCrosses)
{
    Scene scene = house();
    scene.objects[1].worldFromObject = glm::translate(mat4(1.0f), vec3(0.0f, 4.0f, 0.0f));
    bool asked = false;
    const UnwrappedScene after = cutAndCheck(scene, [&](const Scene& s, std::span<const CrossingPoint> points) {
        asked = true;
        return ofWalls(s, points);
    });
    const UnwrappedScene before = *unwrap(scene, settings());
    EXPECT_FALSE(asked);
    EXPECT_EQ(after.cuts, 0);
    EXPECT_EQ(checkMeshes(scene, after), "");
    for (std::size_t m = 0; m < before.scene.meshes.size(); ++m) {
        EXPECT_EQ(after.scene.meshes[m].parts[0].indices, before.scene.meshes[m].parts[0].indices);
        EXPECT_EQ(after.scene.meshes[m].parts[0].lightmapUv, before.scene.meshes[m].parts[0].lightmapUv);
    }
}

TEST(CutsS6, NothingIsCutWhereBothSidesSeeOneAnother)
{
    const Scene scene = house();
    const UnwrappedScene after = cutAndCheck(scene, [](const Scene&, std::span<const CrossingPoint> points) {
        EXPECT_FALSE(points.empty());
        return std::vector<uint8_t>(points.size(), 0);
    });
    EXPECT_EQ(after.cuts, 0);
    EXPECT_EQ(checkMeshes(scene, after), "");
}

/// A board's two sides are one crossing.
TEST(CutsS6, ThinBoardsCutOnce)
{
    Scene scene = house();
    scene.meshes[1] = shapes::box(vec3(2.4f, 0.02f, 2.4f));
    EXPECT_EQ(cutAndCheck(scene).cuts, 4);
}

/// Two objects of one mesh, one with a floor: that one gets a mesh of its own.
TEST(CutsS6, OtherObjectsOfAMeshStayAsTheyAre)
{
    Scene scene = house();
    shapes::add(scene, 0, glm::translate(mat4(1.0f), vec3(10.0f, 0.0f, 0.0f)));
    const UnwrappedScene after = cutAndCheck(scene);
    EXPECT_EQ(after.cuts, 4);
    ASSERT_NE(after.scene.objects[0].mesh, after.scene.objects[2].mesh);
    const Mesh& cut = after.scene.meshes[std::size_t(after.scene.objects[0].mesh)];
    const Mesh& whole = after.scene.meshes[std::size_t(after.scene.objects[2].mesh)];
    EXPECT_EQ(cut.sourceMesh, whole.sourceMesh);
    EXPECT_GT(cut.triangleCount(), whole.triangleCount());
    EXPECT_EQ(whole.triangleCount(), scene.meshes[0].triangleCount());
}

/// A second unwrap of a mesh that was cut before divides nothing, and keeps charts apart again.
TEST(CutsS6, CuttingAgainAddsNothing)
{
    UnwrappedScene first = cutAndCheck(house());
    for (Mesh& mesh : first.scene.meshes) {
        for (MeshPart& part : mesh.parts) {
            part.lightmapUv.clear();
            part.sourceVertex.clear();
            part.cutVertices.clear();
        }
    }
    const UnwrappedScene second = cutAndCheck(first.scene);
    EXPECT_EQ(second.cuts, 4);
    EXPECT_EQ(second.scene.meshes[0].triangleCount(), first.scene.meshes[0].triangleCount());
    EXPECT_TRUE(second.scene.meshes[0].parts[0].cutVertices.empty());
    EXPECT_EQ(chartsAcross(second.scene.meshes[0]), 0);
}

/// Where cuts would add too many texels, a warning says so.
TEST(CutsS6, CutsBeyondTheBudgetAreReported)
{
    Scene scene = house();
    scene.meshes[0] = shapes::plane(100.0f, 100.0f);
    scene.meshes[1] = shapes::grid(1, 1, [](float s, float t) { return vec3(0.5f * s, t, 0.0f); });
    for (int i = 0; i < 30; ++i) {
        shapes::add(scene, 1,
                    glm::translate(glm::rotate(mat4(1.0f), 0.2f * float(i), vec3(0, 1, 0)),
                                   vec3(2.0f + float(i), -0.5f, 0.3f)));
    }
    UnwrapSettings coarse = settings();
    coarse.texelsPerMeter = 10.0f;
    coarse.pageSize = 1024;
    const Result<UnwrappedScene> result = unwrap(scene, coarse, {}, ofWalls);
    ASSERT_TRUE(result) << result.error().text();
    EXPECT_GT(result->cuts, 0);
    EXPECT_LT(result->cuts, 30);
    EXPECT_TRUE(std::any_of(result->warnings.begin(), result->warnings.end(), [](const std::string& warning) {
        return warning.find("crossings of surfaces stay uncut") != std::string::npos;
    }));
}

} // namespace
} // namespace halflight::cuts_test
