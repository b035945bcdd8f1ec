// The Delaunay tetrahedra themselves, against their definition by brute force in exact integers.
#include "halflight/scene/tetrahedra.h"
#include "plan_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

namespace halflight::tetrahedra_test {
namespace {

using Wide = __int128;

Wide volumeOf(std::span<const ivec3> points, const std::array<uint32_t, 4>& v)
{
    const glm::i64vec3 a(points[v[0]]);
    const glm::i64vec3 u = glm::i64vec3(points[v[1]]) - a;
    const glm::i64vec3 s = glm::i64vec3(points[v[2]]) - a;
    const glm::i64vec3 t = glm::i64vec3(points[v[3]]) - a;
    return Wide(u.x) * (s.y * t.z - s.z * t.y) - Wide(u.y) * (s.x * t.z - s.z * t.x) +
           Wide(u.z) * (s.x * t.y - s.y * t.x);
}

/// > 0: p strictly inside the sphere through the vertices. The 4 × 4 determinant, expanded along its last column.
Wide sphereTest(std::span<const ivec3> points, const std::array<uint32_t, 4>& v, uint32_t p)
{
    Wide sum = 0;
    for (std::size_t i = 0; i < 4; ++i) {
        std::array<uint32_t, 4> replaced = v;
        replaced[i] = p;
        const glm::i64vec3 d = glm::i64vec3(points[v[i]]) - glm::i64vec3(points[p]);
        sum += volumeOf(points, replaced) * Wide(d.x * d.x + d.y * d.y + d.z * d.z);
    }
    return sum;
}

/// Checks everything but the sphere property; returns six times the total volume.
Wide checkMesh(std::span<const ivec3> points, const std::vector<Tetrahedron>& cells)
{
    Wide total = 0;
    std::set<uint32_t> used;
    for (uint32_t c = 0; c < cells.size(); ++c) {
        const Wide volume = volumeOf(points, cells[c].vertex);
        EXPECT_TRUE(volume > 0) << "cell " << c;
        total += volume;
        used.insert(cells[c].vertex.begin(), cells[c].vertex.end());
        for (std::size_t i = 0; i < 4; ++i) {
            std::set<uint32_t> face(cells[c].vertex.begin(), cells[c].vertex.end());
            face.erase(cells[c].vertex[i]);
            const uint32_t n = cells[c].neighbor[i];
            if (n == kOutside) {
                // A hull face has no point beyond it.
                for (uint32_t p = 0; p < points.size(); ++p) {
                    std::array<uint32_t, 4> replaced = cells[c].vertex;
                    replaced[i] = p;
                    if (volumeOf(points, replaced) < 0) ADD_FAILURE() << "point " << p << " beyond the hull";
                }
                continue;
            }
            const auto& other = cells[n];
            const auto back = std::find(other.neighbor.begin(), other.neighbor.end(), c) - other.neighbor.begin();
            EXPECT_LT(back, 4);
            if (back == 4) continue;
            std::set<uint32_t> otherFace(other.vertex.begin(), other.vertex.end());
            otherFace.erase(other.vertex[std::size_t(back)]);
            EXPECT_EQ(face, otherFace);
        }
    }
    EXPECT_EQ(used.size(), points.size()) << "points without a cell";
    return total;
}

void checkDelaunay(std::span<const ivec3> points, const std::vector<Tetrahedron>& cells)
{
    for (const Tetrahedron& cell : cells) {
        for (uint32_t p = 0; p < points.size(); ++p) {
            if (std::find(cell.vertex.begin(), cell.vertex.end(), p) != cell.vertex.end()) continue;
            EXPECT_TRUE(sphereTest(points, cell.vertex, p) <= 0) << "point " << p << " in a sphere";
        }
    }
}

std::vector<ivec3> latticePoints(uint32_t seed, int count, int limit)
{
    test::Random random(seed);
    std::set<std::array<int, 3>> distinct;
    while (int(distinct.size()) < count) {
        const vec3 p = random.in(vec3(0), vec3(float(limit)));
        distinct.insert({int(p.x), int(p.y), int(p.z)});
    }
    std::vector<ivec3> points;
    for (const auto& p : distinct) points.emplace_back(p[0], p[1], p[2]);
    std::shuffle(points.begin(), points.end(), random.generator());
    return points;
}

std::vector<ivec3> gridPoints(ivec3 size)
{
    std::vector<ivec3> points;
    for (int z = 0; z < size.z; ++z) {
        for (int y = 0; y < size.y; ++y) {
            for (int x = 0; x < size.x; ++x) points.emplace_back(x, y, z);
        }
    }
    return points;
}

TEST(TetrahedraS14, RandomPointsAreDelaunay)
{
    // In a large range (generic), and in small ones, where planes, spheres and lines full of points are the rule.
    for (const int limit : {1 << kLatticeBits, 1000, 12, 6}) {
        for (uint32_t seed = 1; seed <= 4; ++seed) {
            const std::vector<ivec3> points = latticePoints(seed, 150, limit);
            const std::vector<Tetrahedron> cells = tetrahedralize(points);
            ASSERT_FALSE(cells.empty());
            checkMesh(points, cells);
            checkDelaunay(points, cells);
        }
    }
}

// Every sphere test is a tie here; still no flat cell, no hole, and the same six in every cube.
TEST(TetrahedraS14, GridsFallIntoSixTetrahedraPerCube)
{
    for (const ivec3 size : {ivec3(2, 2, 2), ivec3(5, 4, 6), ivec3(9, 2, 3)}) {
        const std::vector<ivec3> points = gridPoints(size);
        const std::vector<Tetrahedron> cells = tetrahedralize(points);
        const int cubes = (size.x - 1) * (size.y - 1) * (size.z - 1);
        EXPECT_EQ(cells.size(), std::size_t(6 * cubes));
        EXPECT_TRUE(checkMesh(points, cells) == Wide(6 * cubes));
        for (const Tetrahedron& cell : cells) {
            ivec3 low(1000);
            ivec3 high(-1000);
            for (const uint32_t v : cell.vertex) {
                low = glm::min(low, points[v]);
                high = glm::max(high, points[v]);
            }
            EXPECT_EQ(high - low, ivec3(1));
        }
    }
}

TEST(TetrahedraS14, GridsWithHolesFillTheirHull)
{
    // Corners stay, so that the hull is the box; two thirds of the rest go.
    const ivec3 size(7, 6, 8);
    test::Random random(3);
    std::vector<ivec3> points;
    for (const ivec3& p : gridPoints(size)) {
        const bool corner = glm::all(glm::equal(p % (size - 1), ivec3(0)));
        if (corner || random.unit() < 0.33f) points.push_back(p);
    }
    const std::vector<Tetrahedron> cells = tetrahedralize(points);
    EXPECT_TRUE(checkMesh(points, cells) == Wide(6 * 6 * 5 * 7));
    checkDelaunay(points, cells);
}

// Two skew lines: n^2 cells on 2n points, and every insertion may free more places than it fills.
TEST(TetrahedraS14, SkewLinesWork)
{
    std::vector<ivec3> points;
    for (int i = 0; i < 20; ++i) points.emplace_back(1000 * i, 0, 0);
    for (int i = 0; i < 20; ++i) points.emplace_back(9500, 1000 * i, 5000);
    const std::vector<Tetrahedron> cells = tetrahedralize(points);
    EXPECT_EQ(cells.size(), 19u * 19u);
    checkMesh(points, cells);
    checkDelaunay(points, cells);
}

TEST(TetrahedraS14, PlanesLinesAndPointsHaveNone)
{
    EXPECT_TRUE(tetrahedralize({}).empty());
    EXPECT_TRUE(tetrahedralize(gridPoints({1, 1, 1})).empty());
    EXPECT_TRUE(tetrahedralize(gridPoints({7, 1, 1})).empty());
    EXPECT_TRUE(tetrahedralize(gridPoints({7, 5, 1})).empty());
}

// The choice among ties is a function of the numbering, not of the order of insertion: a grid within a larger grid
// falls apart in the same way.
TEST(TetrahedraS14, TiesFallByNumberingAlone)
{
    const auto shapes = [](ivec3 size) {
        const std::vector<ivec3> points = gridPoints(size);
        std::set<std::array<int, 12>> result; // vertices relative to the cube, sorted
        for (const Tetrahedron& cell : tetrahedralize(points)) {
            std::array<std::array<int, 3>, 4> v{};
            ivec3 low(1000);
            for (const uint32_t i : cell.vertex) low = glm::min(low, points[i]);
            for (std::size_t i = 0; i < 4; ++i) {
                const ivec3 p = points[cell.vertex[i]] - low;
                v[i] = {p.x, p.y, p.z};
            }
            std::sort(v.begin(), v.end());
            std::array<int, 12> flat{};
            for (std::size_t i = 0; i < 12; ++i) flat[i] = v[i / 3][i % 3];
            result.insert(flat);
        }
        return result;
    };
    EXPECT_EQ(shapes({2, 2, 2}).size(), 6u);
    EXPECT_EQ(shapes({2, 2, 2}), shapes({8, 7, 9}));
}

} // namespace
} // namespace halflight::tetrahedra_test
